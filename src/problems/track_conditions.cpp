#include "problems/track_conditions.hpp"

#include <cmath>
#include <limits>

#include "continuation/problem.hpp"
#include "harmonic/lowest_harmonic.hpp"
#include "support/error.hpp"

namespace dovetail {
namespace {

constexpr const char *doing = "evaluating the condition of a track";
constexpr double farthest_turn = 0.5; // [rad], by which the place of a graze may move from one motion to the next

} // namespace

double Extremum::value() {
  if (!peak_.differentiate(roughly)) return std::numeric_limits<double>::quiet_NaN();
  const double squared = peak_.amplitude() * peak_.amplitude(); // 2 A
  log_slope_ = 2 * peak_.c() / squared;
  return log_slope_ * peak_.omega();
}

double Extremum::derivative(const PathParameter &parameter, Vec row) {
  const double omega = peak_.omega(), a = peak_.amplitude() * peak_.amplitude() / 2;
  const double by_parameter = peak_.by_parameter(parameter) * omega / a;
  peak_.turn();
  check(VecCopy(peak_.turned(), row), doing);
  check(VecScale(row, omega / a), doing);
  check(VecAXPY(row, -omega * log_slope_ / a, peak_.gradient()), doing);
  set_parameter(row, parameter_of(row) + log_slope_); // Omega, the last of these unknowns
  return by_parameter;
}

PhaseResonance::PhaseResonance(PeakEquations &peak) : peak_(peak), row_(peak.system().unknowns()) {
  const HarmonicSystem &system = peak.system();
  const Layout &layout = system.layout();
  const int k = lowest_harmonic(system.loads());
  double *row;
  check(VecGetArray(row_, &row), doing);
  for (PetscInt d = 0; d < layout.own_dofs() && k > 0; ++d)
    for (const int place : {cosine(k), sine(k)})
      row[d * layout.width + place] = force_coefficient(system.loads(), d, place);
  check(VecRestoreArray(row_, &row), doing);
  PetscReal size;
  check(VecNorm(row_, NORM_2, &size), doing);
  if (size == 0)
    throw InputError("path.peak = \"phase\": no load acts in any harmonic, so nothing is in phase with it");
  check(VecScale(row_, 1 / size), doing);
}

double PhaseResonance::value() {
  double value;
  check(VecDot(row_, peak_.y(), &value), doing);
  return value;
}

double PhaseResonance::derivative(const PathParameter &, Vec row) {
  check(VecCopy(row_, row), doing);
  return 0;
}

Grazing::Grazing(PeakEquations &peak, int own_point, const Graze &graze)
    : peak_(peak), own_point_(own_point), graze_(graze), size_(graze.size) {}

// Of the place where the same edge is highest near where it was.
double Grazing::value() {
  double value = 0;
  const auto all = peak_.system().grazes(peak_.y());
  if (own_point_ >= 0) {
    double nearest = farthest_turn;
    value = std::numeric_limits<double>::quiet_NaN();
    Graze found;
    for (const Graze &graze : all[own_point_]) {
      const double apart = std::abs(std::remainder(graze.theta - graze_.theta, 2 * M_PI));
      if (graze.direction != graze_.direction || graze.side != graze_.side || apart >= nearest) continue;
      nearest = apart, found = graze, value = graze.height / size_;
    }
    if (std::isfinite(value)) graze_ = found;
  }
  MPI_Allreduce(MPI_IN_PLACE, &value, 1, MPI_DOUBLE, MPI_SUM, peak_.system().layout().comm);
  return value;
}

double Grazing::derivative(const PathParameter &parameter, Vec row) {
  const Layout &layout = peak_.system().layout();
  double by_parameter = peak_.system().by_parameter(peak_.y(), own_point_, graze_, parameter);
  check(VecSet(row, 0), doing);
  double *own;
  check(VecGetArray(row, &own), doing);
  if (own_point_ >= 0) {
    double *t = own + layout.own_point_offset(own_point_) + graze_.direction * layout.width,
           *n = own + layout.own_point_offset(own_point_) + 2 * layout.width;
    for (int i = 0; i < layout.width; ++i) t[i] = graze_.by_t[i] / size_, n[i] = graze_.by_n[i] / size_;
    by_parameter /= size_;
  }
  check(VecRestoreArray(row, &own), doing);
  MPI_Allreduce(MPI_IN_PLACE, &by_parameter, 1, MPI_DOUBLE, MPI_SUM, layout.comm);
  return by_parameter;
}

// Known to the point's owner.
void Grazing::archive(Archive &archive) {
  double theta = own_point_ >= 0 ? graze_.theta : 0, size = own_point_ >= 0 ? size_ : 0;
  int side = own_point_ >= 0 ? graze_.side : 0;
  const MPI_Comm comm = peak_.system().layout().comm;
  for (double *value : {&theta, &size}) MPI_Allreduce(MPI_IN_PLACE, value, 1, MPI_DOUBLE, MPI_SUM, comm);
  MPI_Allreduce(MPI_IN_PLACE, &side, 1, MPI_INT, MPI_SUM, comm);
  archive.field("side", side);
  archive.field("theta", theta);
  archive.field("size", size);
  if (archive.restores()) graze_.side = side, graze_.theta = theta, size_ = size;
}

} // namespace dovetail
