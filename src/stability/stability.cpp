#include "stability/stability.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "contact/fourier.hpp"
#include "stability/finer_motion.hpp"
#include "stability/hill.hpp"
#include "stability/monodromy.hpp"

namespace dovetail {
namespace {

using Kind = Stability::Kind;
using Verdict = Stability::Verdict;
using Complex = std::complex<double>;

constexpr double not_asked = std::numeric_limits<double>::quiet_NaN();
constexpr double neutral = 1e-9;       // growth that is round-off
constexpr double close_to_one = 0.1;   // multipliers so close to 1 or -1: Hill's method knows better where they pass it
constexpr double coarse = 1e-3;        // error of harmonic balance beyond which Hill's method is asked in any case
constexpr double sampled_error = 0.15; // of multipliers from a sampled derivative, without sliders as states
constexpr int largest_hill = 2500;     // unknowns; two matrices of 50 MB

constexpr double no_nearer = -0.3; // growth at most, if Hill's method finds no exponent near zero

struct Growth {
  double value = not_asked;
  Kind kind = Kind::none; // if it is positive
  bool positive() const { return value > neutral; }
  bool negative() const { return value < -neutral; }
};

double growth_of(double multiplier) { return std::log(std::max(multiplier, 1e-300)) / (2 * M_PI); }

Kind kind_of(Complex value, Kind if_real) { return value.imag() == 0 ? if_real : Kind::second_frequency; }

bool at_one(const std::vector<Complex> &multipliers) {
  return std::any_of(multipliers.begin(), multipliers.end(),
                     [](Complex m) { return std::abs(m - 1.0) < close_to_one || std::abs(m + 1.0) < close_to_one; });
}

} // namespace

struct StabilityTest::Workspace {
  explicit Workspace(const DenseModel &given)
      : model(given), monodromy(model), hill(model),
        cones(std::any_of(given.contact.begin(), given.contact.end(),
                          [](const ContactPoint &point) { return point.law == Law::cone; })) {}

  void prepare(int H) {
    if (H == harmonics) return;
    harmonics = H;
    own.reset();
    if (cones) own.emplace(model, H);
    reading.emplace(model, 2 * H), finer.emplace(model, 2 * H);
  }

  Stability judge(const std::vector<double> &coefficients, double omega) {
    const int n = model.dofs(), w = static_cast<int>(coefficients.size()) / n;
    opinions = {not_asked, not_asked, not_asked};
    prepare(w / 2);
    if (own) {
      own->read(coefficients);
      if (own->sampled()) return by_sampled_hill(omega);
    }
    const int w2 = coefficient_count(2 * harmonics);
    std::vector<double> motion(static_cast<std::size_t>(n) * w2);
    for (int r = 0; r < n; ++r) std::copy_n(&coefficients[r * w], w, &motion[r * w2]);
    reading->read(motion);
    std::vector<Complex> multipliers = monodromy.multipliers(reading->history(), omega);
    const Growth plain = largest(multipliers);
    if (reading->history().linear()) return conclude(plain, {}, true);

    double change = 0;
    finer->read(finer_motion(model, *reading, motion, omega, change));
    multipliers = monodromy.multipliers(finer->history(), omega);
    const Growth fine = largest(multipliers);
    const double doubt = std::abs(fine.value - plain.value);
    opinions.by_monodromy = fine.value, opinions.doubt = doubt;
    const bool sure = doubt < std::abs(fine.value) / 4, clear = sure && change < coarse && !at_one(multipliers);
    if (clear || n * w > largest_hill) return conclude(fine, {}, sure);
    return conclude(fine, by_hill(*reading, omega), sure);
  }

  // What two opinions amount to. A single one counts if it is trusted.
  static Stability conclude(const Growth &by_monodromy, const Growth &by_hill, bool trust_monodromy) {
    const bool alone = std::isnan(by_hill.value);
    const Growth &trusted = (trust_monodromy || alone) && !std::isnan(by_monodromy.value) ? by_monodromy : by_hill;
    Stability out;
    out.growth = trusted.value, out.multiplier = std::exp(2 * M_PI * trusted.value);
    if (alone ? trust_monodromy && by_monodromy.negative() : by_monodromy.negative() && by_hill.negative())
      out.verdict = Verdict::stable;
    if (alone ? trust_monodromy && by_monodromy.positive() : by_monodromy.positive() && by_hill.positive())
      out.verdict = Verdict::unstable;
    if (out.verdict != Verdict::stable)
      out.kind = trusted.positive()        ? trusted.kind
                 : by_hill.positive()      ? by_hill.kind
                 : by_monodromy.positive() ? by_monodromy.kind
                                           : Kind::none;
    return out;
  }

  static Growth largest(const std::vector<Complex> &multipliers) {
    const auto most = std::max_element(multipliers.begin(), multipliers.end(),
                                       [](Complex a, Complex b) { return std::abs(a) < std::abs(b); });
    if (most == multipliers.end()) return {};
    return {growth_of(std::abs(*most)), kind_of(*most, most->real() > 0 ? Kind::jump : Kind::period_doubling)};
  }

  Growth by_hill(const ContactReading &from, double omega) {
    Growth out{no_nearer};
    std::vector<double> blocks;
    const int rigid = monodromy.indifferent();
    for (const Waves waves : {Waves::whole, Waves::half}) {
      const int w = wave_coefficients(waves, harmonics);
      blocks.clear();
      for (int p = 0; p < model.points; ++p) {
        const std::size_t at = blocks.size();
        blocks.resize(at + block_places(model.contact[p].law).size() * w * w);
        write_waves(waves, harmonics, model.contact[p], from.linear(p), from.history(), p, &blocks[at]);
      }
      hill.assemble(waves, harmonics, omega, blocks);
      if (!take_largest(hill.near_zero(), waves, waves == Waves::whole ? rigid : 0, out)) return {};
    }
    opinions.by_hill = out.value;
    return out;
  }

  // For points of law cone that slip or open: the sampled derivative gives the right side where it is clear.
  Stability by_sampled_hill(double omega) {
    std::vector<double> blocks;
    const int w = coefficient_count(harmonics);
    for (int p = 0; p < model.points; ++p) {
      const std::size_t at = blocks.size();
      blocks.resize(at + block_places(model.contact[p].law).size() * w * w);
      own->linear(p).write(model.contact[p], &blocks[at]);
    }
    Stability out;
    Growth growth{no_nearer};
    hill.assemble(Waves::whole, harmonics, omega, blocks);
    if (model.dofs() * w > largest_hill || !take_largest(hill.near_zero(0.5), Waves::whole, 0, growth)) return out;
    opinions.by_hill = growth.value;
    out.growth = growth.value, out.multiplier = std::exp(2 * M_PI * growth.value);
    if (out.multiplier < 1 - sampled_error) out.verdict = Verdict::stable;
    if (out.multiplier > 1 + sampled_error) out.verdict = Verdict::unstable;
    if (growth.positive()) out.kind = growth.kind;
    return out;
  }

  // Adds exponents to those seen, but for the `indifferent` ones, which are 0.
  static bool take_largest(Hill::Exponents exponents, Waves waves, int indifferent, Growth &out) {
    std::sort(exponents.values.begin(), exponents.values.end(),
              [](Complex a, Complex b) { return std::abs(a) < std::abs(b); });
    for (std::size_t i = indifferent; i < exponents.values.size(); ++i)
      if (const Complex s = exponents.values[i]; s.real() > out.value) {
        out = {s.real(), kind_of(s, waves == Waves::whole ? Kind::jump : Kind::period_doubling)};
        if (std::abs(s.imag()) == 0.5) out.kind = Kind::period_doubling; // whole waves reach that far, if asked to
      }
    return exponents.found;
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
