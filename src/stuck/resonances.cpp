#include "stuck/resonances.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "contact/law_traits.hpp"
#include "stuck/low_modes.hpp"
#include "stuck/stuck_basis.hpp"

namespace dovetail {
namespace {

constexpr PetscInt least_modes = 10, most_modes = 80;
constexpr int instants = 128;     // of a period, at which loads are looked at
constexpr double undriven = 1e-9; // modal force relative to the largest: of a load that is orthogonal to the mode

// As many as reach up to `reach`, or `most_modes`.
std::optional<LowModes> modes_up_to(double reach, const PreloadedModel &model, const std::vector<double> &springs,
                                    const Layout &layout) {
  for (PetscInt count = least_modes;; count *= 2) {
    std::optional<LowModes> modes = low_modes(model.reduced, springs, layout, count);
    const bool enough = !modes || std::sqrt(modes->squares.back()) > reach;
    if (enough || count >= std::min(most_modes, layout.dofs())) return modes;
  }
}

ResonanceSet set_of(const LowModes &modes, const Case &study) {
  const auto [low, high] = std::minmax(study.omega_from, study.omega_to);
  const std::vector<int> harmonics = driving_harmonics(study.loads);
  ResonanceSet set;
  for (const double square : modes.squares) {
    const double omega = std::sqrt(std::max(0.0, square));
    int met = 0;
    for (const int k : harmonics)
      if (met == 0 && omega > 0 && low <= omega / k && omega / k <= high) met = k;
    set.omega.push_back(omega), set.in_sweep.push_back(met);
  }
  return set;
}

// F^T v of each load pattern of the case.
std::vector<double> works_of(const PreloadedModel &model, const std::vector<LoadCourse> &loads, const Layout &layout,
                             const double *shape) {
  const std::size_t own_modes = layout.own_modes.size();
  std::vector<double> works;
  for (const LoadCourse &load : loads) {
    const LoadPattern &pattern = model.reduced.loads[model.reduced.load(load.pattern)];
    const double of_modes =
        std::inner_product(shape, shape + own_modes, pattern.fa.begin() + layout.own_modes.begin, 0.0);
    works.push_back(std::inner_product(pattern.fx.begin(), pattern.fx.end(), shape + own_modes, of_modes));
  }
  MPI_Allreduce(MPI_IN_PLACE, works.data(), static_cast<int>(works.size()), MPI_DOUBLE, MPI_SUM, layout.comm);
  return works;
}

double modal_force(const std::vector<double> &works, const std::vector<LoadCourse> &loads, int harmonic) {
  double cosine = 0, sine = 0;
  for (std::size_t j = 0; j < loads.size(); ++j) {
    const std::vector<double> &fourier = loads[j].fourier;
    const std::size_t place = 2 * harmonic - 1;
    if (place < fourier.size()) cosine += works[j] * fourier[place];
    if (place + 1 < fourier.size()) sine += works[j] * fourier[place + 1];
  }
  return std::hypot(cosine, sine);
}

// Of each mode, the harmonics in which the loads do work on it.
std::vector<std::vector<int>> driven_by(const PreloadedModel &model, const std::vector<LoadCourse> &loads,
                                        const Layout &layout, const LowModes &modes) {
  std::vector<std::vector<int>> found(modes.squares.size());
  std::vector<std::vector<double>> works;
  for (std::size_t j = 0; j < found.size(); ++j)
    works.push_back(works_of(model, loads, layout, modes.shapes.data() + j * layout.own_dofs()));
  for (const int k : driving_harmonics(loads)) {
    double largest = 0;
    for (const std::vector<double> &of : works) largest = std::max(largest, modal_force(of, loads, k));
    for (std::size_t j = 0; j < found.size(); ++j)
      if (modal_force(works[j], loads, k) > undriven * largest) found[j].push_back(k);
  }
  return found;
}

double value_at(const std::vector<double> &fourier, double angle) { // eq (10)
  double sum = fourier.empty() ? 0 : fourier[0] / 2;
  for (std::size_t place = 1; place < fourier.size(); ++place) {
    const double k = double((place + 1) / 2);
    sum += fourier[place] * (place % 2 ? std::cos(k * angle) : std::sin(k * angle));
  }
  return sum;
}

// The most that friction at rest can do against a motion x of the own contact dofs.
double friction_against(const PreloadedModel &model, const std::vector<double> &x) {
  double held = 0;
  for (std::size_t p = 0; p < model.contact.size(); ++p) {
    const ContactPoint &point = model.contact[p];
    const double N = std::max(0.0, model.standstill[p].force[2]);
    if (shares_slider(point.law))
      held += point.mu[0] * N * std::hypot(x[3 * p], x[3 * p + 1]);
    else if (has_friction(point.law))
      for (int d = 0; d < 2; ++d) held += point.mu[d] * N * std::abs(x[3 * p + d]);
  }
  return held;
}

// `modes`: of the slipping structure, whose rigid motions nothing but friction holds. At every instant the body gives
// way in the direction in which its mass lets the load push it: where friction cannot hold that, it cannot hold the
// body.
Sliding sliding_of(const PreloadedModel &model, const std::vector<LoadCourse> &loads, const Layout &layout,
                   const LowModes &modes) {
  const std::size_t own = layout.own_dofs(), own_modes = layout.own_modes.size(), contact = own - own_modes;
  const std::size_t rigid = std::count(modes.squares.begin(), modes.squares.end(), 0.0);
  std::vector<std::vector<double>> works;
  std::vector<double> at_rest(rigid);
  for (std::size_t a = 0; a < rigid; ++a) {
    const double *shape = modes.shapes.data() + a * own;
    works.push_back(works_of(model, loads, layout, shape));
    for (std::size_t i = 0; i < contact; ++i) at_rest[a] -= model.reduced.r[i] * shape[own_modes + i];
  }
  MPI_Allreduce(MPI_IN_PLACE, at_rest.data(), static_cast<int>(rigid), MPI_DOUBLE, MPI_SUM, layout.comm);
  Sliding worst;
  double most = 0;
  for (int i = 0; i < instants && rigid > 0; ++i) {
    std::vector<double> push = at_rest, x(contact);
    for (std::size_t a = 0; a < rigid; ++a)
      for (std::size_t j = 0; j < loads.size(); ++j)
        push[a] += works[a][j] * value_at(loads[j].fourier, 2 * M_PI * i / instants);
    double force = 0, largest = 0;
    for (std::size_t a = 0; a < rigid; ++a) {
      force += push[a] * push[a];
      for (std::size_t d = 0; d < contact; ++d) x[d] += push[a] * modes.shapes[a * own + own_modes + d];
    }
    for (const double value : x) largest = std::max(largest, std::abs(value));
    double held = friction_against(model, x);
    MPI_Allreduce(MPI_IN_PLACE, &held, 1, MPI_DOUBLE, MPI_SUM, layout.comm);
    MPI_Allreduce(MPI_IN_PLACE, &largest, 1, MPI_DOUBLE, MPI_MAX, layout.comm);
    const double ratio = force / held;
    if (largest > 0 && ratio > most) most = ratio, worst = {force / largest, held / largest};
  }
  return worst;
}

// A point that cannot lift off always is.
bool closed_at_rest(const ContactPoint &point, const Standstill &at) { return !may_open(point.law) || at.force[2] > 0; }

} // namespace

std::vector<double> closed_springs(const PreloadedModel &model) {
  std::vector<double> springs = stuck_springs(model.contact);
  for (std::size_t p = 0; p < model.contact.size(); ++p)
    if (!closed_at_rest(model.contact[p], model.standstill[p])) std::fill_n(&springs[3 * p], 3, 0.0);
  return springs;
}

std::vector<int> driving_harmonics(const std::vector<LoadCourse> &loads) {
  std::vector<int> found;
  for (const LoadCourse &load : loads)
    for (std::size_t place = 1; place < load.fourier.size(); ++place)
      if (load.fourier[place] != 0) found.push_back(static_cast<int>((place + 1) / 2));
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

Resonances resonances(const PreloadedModel &model, const Case &study) {
  const std::vector<LoadCourse> &loads = study.loads;
  const std::vector<int> harmonics = driving_harmonics(loads);
  const double reach = std::max(study.omega_from, study.omega_to) * (harmonics.empty() ? 1 : harmonics.back());
  const Layout layout(model.reduced, 0);
  const std::vector<double> all = stuck_springs(model.contact), stuck = closed_springs(model);
  std::vector<double> slipping(all.size());
  Resonances out;
  double sums[4] = {}; // points, closed, that may lift, clamping
  for (std::size_t p = 0; p < model.contact.size(); ++p) {
    const bool closed = closed_at_rest(model.contact[p], model.standstill[p]);
    const bool may_lift = may_open(model.contact[p].law);
    slipping[3 * p + 2] = stuck[3 * p + 2];
    sums[0] += 1, sums[1] += closed, sums[2] += may_lift;
    if (may_lift) sums[3] += model.standstill[p].force[2];
  }
  MPI_Allreduce(MPI_IN_PLACE, sums, 4, MPI_DOUBLE, MPI_SUM, layout.comm);
  out.points = int(sums[0]), out.closed = int(sums[1]), out.may_lift = int(sums[2]), out.clamping = sums[3];

  const std::optional<LowModes> held = modes_up_to(reach, model, stuck, layout);
  out.known = held.has_value();
  if (!out.known) return out;
  const PetscInt count = static_cast<PetscInt>(held->squares.size());
  const bool same = out.closed == 0;
  const auto sliding = same ? held : modes_up_to(reach, model, slipping, layout);
  const auto loose = same ? held : modes_up_to(reach, model, std::vector<double>(all.size()), layout);
  out.known = sliding && loose; // an indefinite mass shows in some of them only
  if (!out.known) return out;
  out.stuck = set_of(*held, study), out.slipping = set_of(*sliding, study), out.open = set_of(*loose, study);
  const auto known_up_to = [&](const ResonanceSet &set) {
    return static_cast<PetscInt>(set.omega.size()) == layout.dofs() ? INFINITY : set.omega.back();
  };
  out.reach = std::min({known_up_to(out.stuck), known_up_to(out.slipping), known_up_to(out.open)});
  if (!study.damping.ratios.empty() && out.closed < out.points)
    if (const auto whole = low_modes(model.reduced, all, layout, count)) out.all_stuck = set_of(*whole, study);
  out.driven = driven_by(model, loads, layout, *held);
  out.sliding = sliding_of(model, loads, layout, *sliding);
  return out;
}

} // namespace dovetail
