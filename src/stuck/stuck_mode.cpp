#include "stuck/stuck_mode.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "case/travelling_wave.hpp"
#include "stuck/low_modes.hpp"
#include "stuck/sector_modes.hpp"
#include "support/error.hpp"

namespace dovetail {
namespace {

constexpr PetscInt least_modes = 10;
constexpr std::size_t most_told = 10; // frequencies in a message
constexpr double at_bound = 1e-9;     // of the bound of friction, to rounding errors of the preload
constexpr double same = 1e-9;         // relative, squares of frequencies that are apart by rounding errors alone
constexpr int instants = 64;          // of half a period, at which the onset of a cone is looked for

using Complex = std::complex<double>;

struct Modes {
  std::vector<double> squares; // w^2, ascending, 0 of rigid motions
  std::vector<Complex> shapes; // (modes, own dofs)
};

bool is_closed(const ContactPoint &point, const Standstill &at) {
  return point.law == Law::bilateral || at.force[2] > 0;
}

// Where there is no friction, a direction never sticks.
std::vector<double> springs_at_rest(const PreloadedModel &model) {
  std::vector<double> springs;
  for (std::size_t p = 0; p < model.contact.size(); ++p) {
    const ContactPoint &point = model.contact[p];
    const std::array<double, 3> stuck = stuck_springs(point);
    for (int d = 0; d < 3; ++d)
      springs.push_back(is_closed(point, model.standstill[p]) && (d == 2 || point.mu[d] > 0) ? stuck[d] : 0);
  }
  return springs;
}

Modes modes_at_rest(const PreloadedModel &model, const TravellingWave &wave, const Layout &layout, PetscInt count) {
  const std::vector<double> springs = springs_at_rest(model);
  if (wave.sectors == 0) {
    const auto modes = low_modes(model.reduced, springs, layout, count);
    if (!modes) throw InputError(mass_not_positive(model.reduced.file));
    return {modes->squares, {modes->shapes.begin(), modes->shapes.end()}};
  }
  const SectorModes modes = sector_modes(model.reduced, wave.index(1), springs, static_cast<int>(count));
  Modes own{modes.squares, {}};
  for (int j = 0; j < count; ++j)
    for (PetscInt d = 0; d < layout.own_dofs(); ++d)
      own.shapes.push_back(modes.shapes(static_cast<int>(layout.number(d)), j));
  return own;
}

// As many as it takes to have the one that is wanted.
Modes modes_for(const PreloadedModel &model, const Case &study, const Layout &layout) {
  const ModeWish &wish = *study.mode;
  const TravellingWave wave = study.wave(model.reduced.sectors);
  for (PetscInt count = std::max<PetscInt>(least_modes, wish.number);; count *= 2) {
    Modes modes = modes_at_rest(model, wave, layout, std::min(count, layout.dofs()));
    if (wish.near == 0 || count >= layout.dofs() || std::sqrt(std::max(0.0, modes.squares.back())) > wish.near)
      return modes;
  }
}

std::string frequencies_of(const Modes &modes, const Case &study) {
  std::string text;
  for (std::size_t j = 0; j < std::min(most_told, modes.squares.size()); ++j)
    text += (j ? ", " : "") + std::to_string(j + 1) + ": " +
            study.frequency_unit.text(std::sqrt(std::max(0.0, modes.squares[j])), 6);
  return text + (modes.squares.size() > most_told ? ", ..." : "");
}

std::size_t choose(const Modes &modes, const Case &study) {
  const ModeWish &wish = *study.mode;
  const std::string key = wish.number > 0 ? "mode.number" : "mode.near", place = study.given.at(key) + ": " + key;
  std::size_t best = modes.squares.size();
  if (wish.number > 0) {
    if (static_cast<std::size_t>(wish.number) > modes.squares.size())
      throw InputError(place + " = " + std::to_string(wish.number) + ": the structure has " +
                       std::to_string(modes.squares.size()) +
                       " modes, with its joint stuck at the preload state: " + frequencies_of(modes, study));
    best = wish.number - 1;
    if (!(modes.squares[best] > 0))
      throw InputError(place + " = " + std::to_string(wish.number) +
                       ": is a rigid motion, which nothing brings back; the modes are " + frequencies_of(modes, study));
    return best;
  }
  double distance = INFINITY;
  for (std::size_t j = 0; j < modes.squares.size(); ++j)
    if (const double off = std::abs(std::sqrt(std::max(0.0, modes.squares[j])) - wish.near);
        modes.squares[j] > 0 && off < distance)
      best = j, distance = off;
  if (best == modes.squares.size())
    throw InputError(place +
                     ": the structure has no mode but rigid motions, with its joint stuck at the preload state");
  return best;
}

// Smallest |a| > 0 with |T + a t| = mu (N + a n): where a cone begins to slip, for either sign of the motion.
double cone_onset(const std::array<double, 2> &T, const std::array<double, 2> &t, double bound, double bound_rate) {
  const double A = t[0] * t[0] + t[1] * t[1] - bound_rate * bound_rate,
               B = T[0] * t[0] + T[1] * t[1] - bound * bound_rate, C = T[0] * T[0] + T[1] * T[1] - bound * bound;
  const double q = B + std::copysign(std::sqrt(B * B - A * C), B);         // nothing cancels, and A may be 0
  return std::fmin(std::fmin(std::abs(q / A), std::abs(C / q)), INFINITY); // what is no number counts for nothing
}

// The same of a motion with a phase of its own in each direction: the least over the period.
double cone_onset(const ContactPoint &point, const Standstill &at, const Complex *phi) {
  const double N = at.force[2], bound = point.mu[0] * N;
  const auto when = [&](double theta) {
    const Complex turn = std::polar(1.0, theta);
    const auto now = [&](int d) { return (phi[d] * turn).real(); };
    return cone_onset({at.force[0], at.force[1]}, {point.kt[0] * now(0), point.kt[1] * now(1)}, bound,
                      point.mu[0] * point.kn * now(2));
  };
  const bool in_phase = std::all_of(phi, phi + 3, [](Complex value) { return value.imag() == 0; });
  if (in_phase) return when(0);
  double best = 0, step = M_PI / instants;
  for (int i = 1; i < instants; ++i)
    if (when(i * step) < when(best)) best = i * step;
  for (; step > 1e-9; step /= 2)
    for (const double other : {best - step, best + step})
      if (when(other) < when(best)) best = other;
  return when(best);
}

// Of one point: adds amplitudes at which something happens to it. phi: its motion.
template <class Add> void events_of(const ContactPoint &point, const Standstill &at, const Complex *phi, Add &&add) {
  if (point.law == Law::bilateral) return;
  const double N = at.force[2], gone = std::abs(phi[2]);
  if (!is_closed(point, at)) return add((point.gap - at.x[2]) / gone, point.gap - at.x[2] > 0, "closes");
  add(N / (point.kn * gone), true, "lifts off");
  if (point.law == Law::cone) {
    if (point.mu[0] == 0) return;
    const double bound = point.mu[0] * N, size = std::hypot(at.force[0], at.force[1]);
    add(cone_onset(point, at, phi), size < bound * (1 - at_bound), "slips");
  }
  for (int d = 0; d < 2 && point.law == Law::coulomb; ++d)
    for (const int sense : {1, -1}) {
      if (point.mu[d] == 0) continue;
      const double bound = point.mu[d] * N, left = bound - sense * at.force[d],
                   rate = std::abs(point.kt[d] * phi[d] - sense * point.mu[d] * point.kn * phi[2]);
      add(left / rate, left > at_bound * bound, "slips");
    }
}

Onset first_onset(const PreloadedModel &model, const Complex *contact_shape, bool &straight) {
  Onset first{INFINITY, 0, ""};
  int waiting = 1; // no point is at its bound
  for (std::size_t p = 0; p < model.contact.size(); ++p)
    events_of(model.contact[p], model.standstill[p], contact_shape + 3 * p,
              [&](double amplitude, bool away, const char *what) {
                if (!away && amplitude < INFINITY) waiting = 0;
                if (away && amplitude < first.amplitude)
                  first = {amplitude, static_cast<int>(model.reduced.own_points.begin + p) + 1, what};
              });
  const MPI_Comm comm = model.reduced.comm;
  struct {
    double amplitude;
    int rank;
  } least{first.amplitude, 0};
  MPI_Comm_rank(comm, &least.rank);
  MPI_Allreduce(MPI_IN_PLACE, &least, 1, MPI_DOUBLE_INT, MPI_MINLOC, comm);
  MPI_Allreduce(MPI_IN_PLACE, &waiting, 1, MPI_INT, MPI_LAND, comm);
  straight = waiting != 0;
  static const char *const words[] = {"", "slips", "lifts off", "closes"};
  int said[2] = {first.point, 0};
  for (int i = 0; i < 4; ++i)
    if (std::string(first.what) == words[i]) said[1] = i;
  MPI_Bcast(said, 2, MPI_INT, least.rank, comm);
  return {least.amplitude, said[0], words[said[1]]};
}

// The number of another mode of the same frequency, 0 if there is none.
int twin_of(const std::vector<double> &squares, std::size_t chosen) {
  for (std::size_t j = 0; j < squares.size(); ++j)
    if (j != chosen && std::abs(squares[j] - squares[chosen]) <= same * squares[chosen]) return static_cast<int>(j) + 1;
  return 0;
}

// So that the sign does not depend on how the mode was found; one of a sector has its phase already.
void turn_to_positive(std::vector<Complex> &shape, MPI_Comm comm) {
  double most = 0, least = 0;
  for (const Complex value : shape) most = std::max(most, value.real()), least = std::min(least, value.real());
  double sizes[] = {most, -least};
  MPI_Allreduce(MPI_IN_PLACE, sizes, 2, MPI_DOUBLE, MPI_MAX, comm);
  if (sizes[1] > sizes[0] * (1 + 1e-9))
    for (Complex &value : shape) value = -value;
}

} // namespace

StuckMode stuck_mode(const PreloadedModel &model, const Case &study) {
  const Layout layout(model.reduced, 0);
  const Modes modes = modes_for(model, study, layout);
  const std::size_t chosen = choose(modes, study), own = layout.own_dofs(), first = layout.own_modes.size();
  StuckMode mode;
  mode.number = static_cast<int>(chosen) + 1, mode.omega = std::sqrt(modes.squares[chosen]);
  mode.twin = twin_of(modes.squares, chosen);
  std::vector<Complex> shape(modes.shapes.begin() + chosen * own, modes.shapes.begin() + (chosen + 1) * own);
  if (model.reduced.sectors == 0) turn_to_positive(shape, layout.comm);
  mode.modal.assign(shape.begin(), shape.begin() + first), mode.contact.assign(shape.begin() + first, shape.end());
  for (const Complex value : mode.contact) mode.largest = std::max(mode.largest, std::abs(value));
  MPI_Allreduce(MPI_IN_PLACE, &mode.largest, 1, MPI_DOUBLE, MPI_MAX, layout.comm);
  mode.onset = first_onset(model, mode.contact.data(), mode.straight);
  return mode;
}

} // namespace dovetail
