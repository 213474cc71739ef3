#include "stability/sector_stability.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "case/judged_sector.hpp"
#include "contact/fourier.hpp"
#include "stability/growth.hpp"
#include "support/error.hpp"
#include "support/gathered.hpp"

namespace dovetail {
namespace {

constexpr int strips = 4; // that exponents are sought in, side by side: Im of lambda / Omega near 0, 1/4, 1/2, 3/4
constexpr double accuracy = 1e-7; // of exponents over Omega

int modulo(int a, int n) { return (a % n + n) % n; }

constexpr double contenders = 0.005; // exponents slower than the fastest by more keep the lag of their strip
constexpr int rounds = 8;            // of the search for one with its own

// The exponent near s (over Omega) with the lag that sliders have under a change that grows so; nothing if the search
// does not settle. `equations`: makes them with the lag of s.
template <class Equations>
std::optional<std::complex<double>> with_own_lag(SectorHill &hill, double width, std::complex<double> s,
                                                 const Equations &equations) {
  for (int round = 0; round < rounds; ++round) {
    equations(s);
    std::complex<double> next(INFINITY, 0);
    for (const std::complex<double> t : hill.near_zero(width).values)
      if (std::abs(t - s.real()) < std::abs(next - s.real())) next = t;
    if (!std::isfinite(next.real())) return std::nullopt;
    next += std::complex<double>(0, s.imag());
    if (std::abs(next - s) < accuracy) return next;
    s = next;
  }
  return std::nullopt;
}

} // namespace

SectorStabilityTest::SectorStabilityTest(const HarmonicSystem &system) : comm_(system.layout().comm) {
  if (!system.scaled().damping.acts_in_time()) throw ComputeError("stability: not with hysteretic damping");
  const Layout &layout = system.layout();
  equations_.sectors = system.wave().sectors, equations_.engine_order = system.wave().engine_order;
  equations_.modes = static_cast<int>(layout.modes), equations_.points = static_cast<int>(layout.points);
  equations_.of_index = &system.every_index();
  equations_.damping = system.damping();
  points_.modes = equations_.modes, points_.points = equations_.points;
  points_.contact = everywhere(comm_, system.contact()), points_.standstill = everywhere(comm_, system.standstill());
  const Dampers *dampers = system.dampers();
  if (!dampers || !dampers->is_viscous()) return;
  const PetscInt rows = 3 * layout.points;
  std::vector<PetscInt> place(layout.dofs(), -1); // of each contact row of the harmonic system
  for (PetscInt i = 0; i < rows; ++i) place[layout.contact_row(i)] = i;
  equations_.C.resize(rows * rows);
  for (const Dampers::Entry &c : everywhere(comm_, dampers->entries()))
    equations_.C[place.at(c.row) * rows + place.at(c.column)] += c.viscous * system.setting().damping;
}

// A change and its conjugate grow alike: n with lambda, -n with its conjugate, and that is EO - n with the conjugate
// and i Omega more. Of two such problems the first is solved.
std::vector<SectorStabilityTest::Task> SectorStabilityTest::tasks(bool sampled) const {
  std::vector<Task> all;
  const int N = equations_.sectors;
  for (int strip = 0; strip <= (sampled ? 0 : strips / 2); ++strip)
    for (int n = 0; n < N; ++n) {
      const int mirror = modulo(strip == 0 ? -n : equations_.engine_order - n, N);
      if ((strip == 0 || 2 * strip == strips) && mirror < n) continue;
      all.push_back({n, strip});
    }
  return all;
}

Stability SectorStabilityTest::judge(const std::vector<double> &coefficients, double omega) {
  const int harmonics = static_cast<int>(coefficients.size()) / equations_.dofs() / 2;
  if (3 * equations_.points * coefficient_count(harmonics) > most_judged_of_sector) return {}; // harmonics were added
  ContactReading reading(points_, harmonics);
  reading.read(coefficients);
  const bool sampled = reading.sampled();
  const double width = sampled ? 0.5 : 0.5 / strips;
  int rank, size;
  MPI_Comm_rank(comm_, &rank);
  MPI_Comm_size(comm_, &size);
  const std::vector<Task> all = tasks(sampled);
  constexpr int numbers = 3; // growth, kind, diameter
  std::vector<double> found(numbers * all.size(), -INFINITY);
  SectorHill hill(equations_);
  for (int strip = 0; strip <= all.back().strip; ++strip) {
    const ComplexWaves waves(strip / static_cast<double>(strips), harmonics);
    const std::vector<std::complex<double>> blocks = answers(waves, reading, points_.contact);
    for (std::size_t i = rank; i < all.size(); i += size) {
      if (all[i].strip != strip) continue;
      hill.assemble(all[i].shift, waves, omega, blocks, points_.contact);
      const SectorHill::Exponents exponents = hill.near_zero(width);
      Growth growth = exponents.found ? fastest_of(exponents.values, waves.part) : Growth{};
      if (growth.known() && !sampled && !reading.history().holds.empty()) {
        std::vector<std::complex<double>> exact;
        const auto equations = [&](std::complex<double> s) {
          const ComplexWaves own(s.imag(), harmonics, s.real());
          hill.assemble(all[i].shift, own, omega, answers(own, reading, points_.contact), points_.contact);
        };
        bool settled = true;
        for (const std::complex<double> &s : exponents.values)
          if (s.real() >= growth.value - contenders) {
            const auto found_again = with_own_lag(hill, width, s + std::complex<double>(0, waves.part), equations);
            settled = settled && found_again;
            if (found_again) exact.push_back(*found_again);
          }
        growth = settled ? fastest_of(exact, 0) : Growth{};
      }
      double *to = &found[numbers * i];
      to[0] = growth.known() ? growth.value : INFINITY, to[1] = static_cast<int>(growth.kind),
      to[2] = exponents.diameter;
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, found.data(), static_cast<int>(found.size()), MPI_DOUBLE, MPI_MAX, comm_);
  std::size_t most = 0;
  for (std::size_t i = 1; i < all.size(); ++i)
    if (found[numbers * i] > found[numbers * most]) most = i;
  const double *of = &found[numbers * most];
  Growth growth; // not known if one of them is not
  if (std::isfinite(of[0])) growth = {of[0], static_cast<Stability::Kind>(of[1])};
  Stability out = sampled ? conclude_sampled(growth) : conclude_alone(growth, accuracy);
  if (out.kind != Stability::Kind::none) out.diameter = static_cast<int>(of[2]);
  return out;
}

} // namespace dovetail
