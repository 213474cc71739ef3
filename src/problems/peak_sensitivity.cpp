#include "problems/peak_sensitivity.hpp"

#include <algorithm>
#include <cmath>

#include "support/error.hpp"

namespace dovetail {
namespace {

constexpr const char *doing = "differentiating a peak";
constexpr int most_corrections = 12;    // of a motion at one frequency; from a point of the curve one or two are enough
constexpr int most_moves = 12;          // of the frequency
constexpr double exact = 1e-11;         // relative change of the last correction
constexpr double still = 1e-10;         // of the frequency, when it is the peak's
constexpr double farthest = 0.02;       // of the frequency: a peak beyond is another one
constexpr double part_of_motion = 1e-6; // for central differences along a motion: half the digits
constexpr double part_of_omega =
    1e-3; // along the frequency, of which the equations are a quadratic: no error of its own

double dot(Vec a, Vec b) {
  double value;
  check(VecDot(a, b, &value), doing);
  return value;
}

// Equations at a motion and a frequency, with the adjoint of the watched amplitude. c = -dA/dOmega, 2 A = amplitude^2.
class Peak {
public:
  Peak(const HarmonicSystem &like, Vec y, const Watched &watched)
      : system_(HarmonicSystem::assembled(like, exactly)), jacobian_(system_->matrix()), fixed_(system_->unknowns()) {
    const Layout &layout = system_->layout();
    for (PetscInt d = 0; d < layout.own_dofs(); ++d) {
      const PetscInt number = layout.number(d);
      row_.push_back(watched.row ? (*watched.row)[number] : number == watched.dof);
    }
    for (UniqueVec *v : {&y_, &f_, &along_, &gradient_, &adjoint_, &turned_, &at_}) *v = system_->unknowns();
    check(VecCopy(y, y_), doing);
    set_last(fixed_, 1);
    check(KSPCreate(layout.comm, ksp_.out()), doing);
    system_->set_up(ksp_, jacobian_);
  }

  double omega() const { return system_->parameter_in(y_); }
  double amplitude() const { return std::sqrt(dot(gradient_, y_)); } // a quadratic's

  // Newton's method at the frequency at hand.
  bool solve() {
    for (int i = 0; i < most_corrections; ++i) {
      PetscReal size, change;
      system_->residual(y_, f_);
      set_last(f_, 0);
      factor(fixed_);
      if (!solve(f_, at_, false)) return false;
      check(VecAXPY(y_, -1, at_), doing);
      check(VecNorm(y_, NORM_2, &size), doing);
      check(VecNorm(at_, NORM_2, &change), doing);
      if (!std::isfinite(change)) return false;
      if (change <= exact * size) return true;
    }
    return false;
  }

  // dY/dOmega, the adjoint and c; then c's own derivatives. False where a solve fails.
  bool differentiate() {
    factor(fixed_);
    if (!solve(fixed_, along_, false)) return false; // [dY/dOmega; 1]
    check(VecSet(gradient_, 0), doing);
    watch(y_, gradient_);
    if (!solve(gradient_, adjoint_, true)) return false; // [lambda; -c]
    c_ = -system_->parameter_in(adjoint_);
    set_last(adjoint_, 0);
    PetscReal size, rate;
    check(VecNorm(y_, NORM_2, &size), doing);
    check(VecNorm(along_, NORM_2, &rate), doing);
    step_ = part_of_motion * size / rate;
    set_last(along_, 0);
    check(VecSet(turned_, 0), doing); // [c_Y; c_Omega]
    const double turn = part_of_omega * omega();
    for (const double side : {1.0, -1.0}) {
      add_transposed(side * step_, 0, side / (2 * step_));
      add_transposed(0, side * turn, side / (2 * turn));
    }
    check(VecSet(f_, 0), doing);
    watch(along_, f_);
    check(VecAXPY(turned_, -1, f_), doing);
    return true;
  }
  double c() const { return c_; }
  double slope() const { return system_->parameter_in(turned_) + dot(turned_, along_); }

  // To another frequency, along the curve.
  void move(double by) {
    const double next = omega() + by;
    check(VecAXPY(y_, by, along_), doing);
    set_last(y_, next);
  }

  std::optional<PeakSensitivity> sensitivity() {
    PeakSensitivity out;
    out.omega = omega(), out.amplitude = amplitude();
    const PeakSlope here = weighed(0, adjoint_);
    out.amplitude_by = scaled(here, -1 / out.amplitude); // dA/dp = -lambda . R_p
    const double turn = part_of_omega * omega();
    double turned_damping = 0; // lambda . d R_p/dOmega: of these parameters damping alone is one of both
    for (const double side : {1.0, -1.0}) {
      check(VecCopy(y_, f_), doing);
      set_last(f_, omega() + side * turn);
      turned_damping += system_->weighed_damping(f_, adjoint_) * side / (2 * turn);
    }
    // [J R_Omega; c_Y c_Omega] [dY; dOmega] = -[R_p; c_p]
    factor(turned_);
    if (!solve(fixed_, at_, true)) return std::nullopt;
    const double last = system_->parameter_in(at_);
    set_last(at_, 0);
    out.omega_by = scaled(weighed(0, at_), -1);
    for (const double side : {1.0, -1.0}) // c_p = lambda . dR_p/dY dY/dOmega
      add(out.omega_by, weighed(side * step_, adjoint_), -last * side / (2 * step_));
    out.omega_by.damping -= last * turned_damping;
    return out;
  }

private:
  void set_last(Vec v, double value) const {
    if (system_->layout().owns_omega())
      check(VecSetValue(v, system_->layout().omega_row(), value, INSERT_VALUES), doing);
    check(VecAssemblyBegin(v), doing);
    check(VecAssemblyEnd(v), doing);
  }

  void factor(Vec border) {
    system_->jacobian(y_, border, jacobian_);
    check(KSPSetOperators(ksp_, jacobian_, jacobian_), doing);
  }

  bool solve(Vec right, Vec x, bool transposed) {
    KSPConvergedReason reason;
    check(transposed ? KSPSolveTranspose(ksp_, right, x) : KSPSolve(ksp_, right, x), doing);
    check(KSPGetConvergedReason(ksp_, &reason), doing);
    if (reason <= 0) system_->recover(ksp_, jacobian_);
    return reason > 0;
  }

  // out += H v, where 2 A = v . H v.
  void watch(Vec v, Vec out) const {
    const Layout &layout = system_->layout();
    const int n = layout.width;
    const double *from;
    double *to;
    std::vector<double> motion(n, 0.0); // of what is watched, without its mean
    check(VecGetArrayRead(v, &from), doing);
    check(VecGetArray(out, &to), doing);
    for (std::size_t d = 0; d < row_.size(); ++d)
      for (int i = 1; i < n; ++i) motion[i] += row_[d] * from[d * n + i];
    MPI_Allreduce(MPI_IN_PLACE, motion.data(), n, MPI_DOUBLE, MPI_SUM, layout.comm);
    for (std::size_t d = 0; d < row_.size(); ++d)
      for (int i = 1; i < n; ++i) to[d * n + i] += row_[d] * motion[i];
    check(VecRestoreArray(out, &to), doing);
    check(VecRestoreArrayRead(v, &from), doing);
  }

  // turned_ += weight [J R_Omega]^T lambda, at y + h dY/dOmega and Omega + turn.
  void add_transposed(double h, double turn, double weight) {
    check(VecWAXPY(at_, h, along_, y_), doing);
    set_last(at_, omega() + turn);
    system_->jacobian(at_, fixed_, jacobian_);
    check(MatMultTranspose(jacobian_, adjoint_, f_), doing);
    check(VecAXPY(turned_, weight, f_), doing);
  }

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

  std::unique_ptr<HarmonicSystem> system_;
  UniqueMat jacobian_;
  UniqueKSP ksp_;
  std::vector<double> row_; // (own dofs): what is watched is this times q
  UniqueVec y_, f_, along_, gradient_, adjoint_, turned_, at_;
  UniqueVec fixed_; // border that holds Omega: the last unit vector
  double c_ = 0, step_ = 0;
};

} // namespace

std::optional<PeakSensitivity> peak_sensitivity(const HarmonicSystem &system, Vec y, const Watched &watched) {
  Peak peak(system, y, watched);
  const double begin = peak.omega();
  for (int i = 0; i < most_moves; ++i) {
    if (!peak.solve() || !peak.differentiate() || peak.slope() <= 0) return std::nullopt;
    const double by = -peak.c() / peak.slope();
    if (std::abs(by) <= still * begin) return peak.sensitivity();
    if (std::abs(peak.omega() + by - begin) > farthest * begin) return std::nullopt;
    peak.move(by);
  }
  return std::nullopt;
}

} // namespace dovetail
