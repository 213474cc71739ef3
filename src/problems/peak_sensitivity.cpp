#include "problems/peak_sensitivity.hpp"

#include "continuation/problem.hpp"
#include "problems/peak_equations.hpp"
#include "support/error.hpp"

namespace dovetail {
namespace {

constexpr const char *doing = "differentiating a peak";

class Peak : public PeakEquations {
public:
  using PeakEquations::PeakEquations;

  std::optional<PeakSensitivity> sensitivity() {
    PeakSensitivity out;
    out.omega = omega(), out.amplitude = amplitude();
    const PeakSlope here = weighed(0, adjoint_);
    out.amplitude_by = scaled(here, -1 / out.amplitude); // dA/dp = -lambda . R_p
    const double turned_damping = omega_by_damping();
    // [J R_Omega; c_Y c_Omega] [dY; dOmega] = -[R_p; c_p]
    factor(turned_, true);
    if (!solve(fixed_, at_, true)) return std::nullopt;
    const double last = system_->parameter_in(at_);
    set_parameter(at_, 0);
    out.omega_by = scaled(weighed(0, at_), -1);
    for (const double side : {1.0, -1.0}) // c_p = lambda . dR_p/dY dY/dOmega
      add(out.omega_by, weighed(side * step_, adjoint_), -last * side / (2 * step_));
    out.omega_by.damping -= last * turned_damping;
    return out;
  }

private:
  // weights . R_p at y + h dY/dOmega
  PeakSlope weighed(double h, Vec weights) {
    UniqueVec there = system_->unknowns();
    check(VecWAXPY(there, h, along_, y_), doing);
    PeakSlope out{system_->weighed(there, weights), 0, 0, system_->weighed_damping(there, weights)};
    const Layout &layout = system_->layout();
    const std::vector<double> &r = system_->scaled().model.reduced.r;
    const double *w;
    check(VecGetArrayRead(weights, &w), doing);
    double sums[2] = {0, 0};
    for (PetscInt i = 0; i < layout.own_coefficients(); ++i)
      sums[0] -= w[i] * force_coefficient(system_->loads(), i / layout.width, i % layout.width);
    for (std::size_t i = 0; i < r.size(); ++i)
      sums[1] += 2 * w[layout.own_point_offset(0) + static_cast<PetscInt>(i) * layout.width] * r[i];
    check(VecRestoreArrayRead(weights, &w), doing);
    MPI_Allreduce(MPI_IN_PLACE, sums, 2, MPI_DOUBLE, MPI_SUM, layout.comm);
    out.force = sums[0], out.preload = sums[1];
    return out;
  }

  static void add(PeakSlope &to, const PeakSlope &other, double factor) {
    for (std::size_t p = 0; p < to.points.size(); ++p) {
      ByParameter &a = to.points[p];
      const ByParameter &b = other.points[p];
      a.normal_stiffness += factor * b.normal_stiffness, a.gap += factor * b.gap;
      for (int d = 0; d < 2; ++d) {
        a.tangential_stiffness[d] += factor * b.tangential_stiffness[d];
        a.friction[d] += factor * b.friction[d];
      }
    }
    to.force += factor * other.force, to.preload += factor * other.preload, to.damping += factor * other.damping;
  }
  static PeakSlope scaled(const PeakSlope &one, double factor) {
    PeakSlope out{std::vector<ByParameter>(one.points.size()), 0, 0, 0};
    add(out, one, factor);
    return out;
  }
};

} // namespace

std::optional<PeakSensitivity> peak_sensitivity(const HarmonicSystem &system, Vec y, const Watched &watched) {
  Peak peak(system, watched);
  peak.take(y);
  if (!peak.climb()) return std::nullopt;
  return peak.sensitivity();
}

} // namespace dovetail
