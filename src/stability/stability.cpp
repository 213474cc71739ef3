#include "stability/stability.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "contact/fourier.hpp"
#include "contact/law_traits.hpp"
#include "stability/finer_motion.hpp"
#include "stability/growth.hpp"
#include "stability/hill.hpp"
#include "stability/monodromy.hpp"

namespace dovetail {
namespace {

using Multipliers = std::vector<std::complex<double>>;

constexpr double close_to_one = 0.1; // multipliers so close to 1 or -1: Hill's method knows better where they pass it,
constexpr double passing = 1e-6;     // if their growth is that small, or hardly more than its doubt
constexpr double coarse = 1e-3;      // error of harmonic balance beyond which Hill's method is asked in any case
constexpr double sure = 0.25;        // doubt over growth that leaves no doubt about its sign
constexpr int second_opinion = 600;  // unknowns of contact points up to which Hill's method is asked besides, and
constexpr int only_opinion = 2500;   // where there is no other: 50 MB

bool passes_one(const Multipliers &multipliers, double doubt) {
  return std::any_of(multipliers.begin(), multipliers.end(), [&](std::complex<double> m) {
    return std::min(std::abs(m - 1.0), std::abs(m + 1.0)) < close_to_one &&
           std::abs(std::log(std::abs(m))) / (2 * M_PI) < passing + 10 * doubt;
  });
}

} // namespace

struct StabilityTest::Workspace {
  explicit Workspace(const DenseModel &given)
      : model(given), monodromy(model), hill(model),
        cones(std::any_of(given.contact.begin(), given.contact.end(),
                          [](const ContactPoint &point) { return shares_slider(point.law); })) {}

  Stability judge(const std::vector<double> &coefficients, double omega) {
    const int n = model.dofs(), w = static_cast<int>(coefficients.size()) / n;
    const Growth unknown;
    opinions = {unknown.value, unknown.value, unknown.value};
    prepare(w / 2);
    if (own) {
      own->read(coefficients);
      if (own->sampled()) return conclude_sampled(by_hill(Waves::whole, *own, omega, 0.5));
    }
    const int w2 = coefficient_count(2 * harmonics);
    std::vector<double> motion(static_cast<std::size_t>(n) * w2);
    for (int r = 0; r < n; ++r) std::copy_n(&coefficients[r * w], w, &motion[r * w2]);
    reading->read(motion);
    const Growth plain = largest_of(monodromy.multipliers(reading->history(), omega));
    opinions.by_monodromy = plain.value, opinions.doubt = 0;
    if (reading->history().linear()) return conclude(plain, unknown, true);

    double change = 0;
    finer->read(finer_motion(model, *reading, motion, omega, change));
    const Multipliers multipliers = monodromy.multipliers(finer->history(), omega);
    const Growth fine = largest_of(multipliers);
    opinions.by_monodromy = fine.value, opinions.doubt = std::abs(fine.value - plain.value);
    const bool trusted = opinions.doubt < sure * std::abs(fine.value);
    const bool clear = trusted && change < coarse && !passes_one(multipliers, opinions.doubt);
    if (clear || contact_unknowns() > second_opinion) return conclude(fine, unknown, trusted);
    return conclude(fine, larger(by_hill(Waves::whole, *reading, omega), by_hill(Waves::half, *reading, omega)),
                    trusted);
  }

  void prepare(int H) {
    if (H == harmonics) return;
    harmonics = H;
    if (cones) own.emplace(model, H);
    reading.emplace(model, 2 * H), finer.emplace(model, 2 * H);
  }

  int contact_unknowns() const { // that Hill's method factors
    return (model.C.empty() ? 3 * model.points : model.dofs()) * coefficient_count(harmonics);
  }

  Growth by_hill(Waves waves, const ContactReading &from, double omega, double strip = 0.25) {
    if (contact_unknowns() > only_opinion) return {};
    hill.assemble(waves, harmonics, omega, from.answers(waves, harmonics, exponent_shift), from.history().holds);
    const Hill::Exponents exponents = hill.near_zero(strip);
    if (!exponents.found) return {};
    const Growth out = largest_of(exponents.values, waves, waves == Waves::whole ? monodromy.indifferent() : 0);
    opinions.by_hill = std::fmax(opinions.by_hill, out.value);
    return out;
  }

  DenseModel model;
  Monodromy monodromy;
  Hill hill;
  bool cones; // some point has that law
  int harmonics = 0;
  std::optional<ContactReading> own;            // with the harmonics of the motion; for cones only
  std::optional<ContactReading> reading, finer; // with twice as many
  Opinions opinions{};
};

StabilityTest::StabilityTest(const DenseModel &model) : work_(std::make_unique<Workspace>(model)) {}
StabilityTest::~StabilityTest() = default;

Stability StabilityTest::judge(const std::vector<double> &coefficients, double omega) {
  return work_->judge(coefficients, omega);
}

const StabilityTest::Opinions &StabilityTest::opinions() const { return work_->opinions; }

} // namespace dovetail
