#include "problems/peak_track.hpp"

#include <cmath>
#include <limits>

#include "problems/forced_response.hpp"
#include "problems/track_jacobian.hpp"
#include "support/error.hpp"

namespace dovetail {
namespace {

constexpr const char *doing = "following a peak";

} // namespace

std::vector<double> TrackMetric::products(const std::vector<Pair> &pairs, const std::vector<Vec> &moving,
                                          const std::vector<Vec> &) const {
  std::vector<double> sums = response_.products(pairs, moving, {}); // their last but one is Omega
  for (std::size_t i = 0; i < pairs.size(); ++i)
    sums[i] += parameter_of(pairs[i][0]) * parameter_of(pairs[i][1]) / (unit_ * unit_);
  return sums;
}

void TrackMetric::weigh(Vec t, Vec row) const {
  response_.weigh(t, row);
  set_parameter(row, parameter_of(t) / (unit_ * unit_));
}

PeakTrack::PeakTrack(PeakEquations &peak, const PathParameter &kind, std::shared_ptr<VariedPreload> preload,
                     TrackCondition &condition, double omega_unit)
    : peak_(peak), kind_(kind), preload_(std::move(preload)), condition_(condition),
      omega_unit_(omega_unit), parameter_{kind.name, kind.unit}, inner_(peak.system().unknowns()),
      f_(peak.system().unknowns()), known_(unknowns()) {
  check(VecSet(known_, std::numeric_limits<double>::quiet_NaN()), doing); // equal to nothing
}

UniqueVec PeakTrack::unknowns() const {
  const Layout &layout = peak_.system().layout();
  UniqueVec y;
  check(VecCreateMPI(layout.comm, own_unknowns() + (layout.owns_omega() ? 1 : 0), layout.unknowns() + 1, y.out()),
        doing);
  check(VecSet(y, 0), doing);
  return y;
}

void PeakTrack::take(Vec y) {
  hand_over(y);
  check(VecSet(known_, std::numeric_limits<double>::quiet_NaN()), doing); // others may go on with the equations
}

void PeakTrack::hand_over(Vec y) {
  const double *from;
  double *to;
  const double p = parameter_of(y);
  check(VecGetArrayRead(y, &from), doing);
  check(VecGetArray(inner_, &to), doing);
  std::copy_n(from, own_unknowns(), to);
  check(VecRestoreArray(inner_, &to), doing);
  check(VecRestoreArrayRead(y, &from), doing);
  peak_.take(inner_);
  peak_.set(kind_, p, preload_);
}

void PeakTrack::give(double p, Vec y) const {
  const double *from;
  double *to;
  check(VecGetArrayRead(peak_.y(), &from), doing);
  check(VecGetArray(y, &to), doing);
  std::copy_n(from, own_unknowns(), to);
  check(VecRestoreArray(y, &to), doing);
  check(VecRestoreArrayRead(peak_.y(), &from), doing);
  set_parameter(y, p);
}

double PeakTrack::omega_of(Vec y) const {
  const Layout &layout = peak_.system().layout();
  const double *own;
  check(VecGetArrayRead(y, &own), doing);
  double omega = layout.owns_omega() ? own[layout.own_coefficients()] : 0;
  check(VecRestoreArrayRead(y, &own), doing);
  MPI_Bcast(&omega, 1, MPI_DOUBLE, layout.size - 1, layout.comm);
  return omega;
}

// The condition at y, which the equations take.
double PeakTrack::evaluate(Vec y) {
  PetscBool same;
  check(VecEqual(y, known_, &same), doing);
  hand_over(y);
  if (same) return known_value_;
  known_value_ = condition_.value();
  check(VecCopy(y, known_), doing);
  return known_value_;
}

void PeakTrack::residual(Vec y, Vec f) {
  const double condition = evaluate(y);
  peak_.system().residual(peak_.y(), f_); // last: what is known of the motion is of here
  const PetscInt own = own_unknowns();
  const bool last = peak_.system().layout().owns_omega();
  const double *from;
  double *to;
  check(VecGetArrayRead(f_, &from), doing);
  check(VecGetArray(f, &to), doing);
  std::copy_n(from, own, to);
  if (last) to[own - 1] = condition;
  check(VecRestoreArray(f, &to), doing);
  check(VecRestoreArrayRead(f_, &from), doing);
}

std::unique_ptr<BorderedJacobian> PeakTrack::jacobian() { return std::make_unique<TrackJacobian>(*this); }

std::unique_ptr<ArcLengthMetric> PeakTrack::metric(double unit, bool weighted) const {
  return std::make_unique<TrackMetric>(peak_.system().layout(), omega_unit_, unit, weighted);
}

std::shared_ptr<PointData> PeakTrack::describe() {
  auto data = std::make_shared<ResponseData>();
  data->activity = peak_.system().activity();
  return data;
}

} // namespace dovetail
