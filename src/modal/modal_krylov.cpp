#include "modal/modal_krylov.hpp"

#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "support/shell.hpp"

namespace dovetail {
namespace {

constexpr const char *doing = "solving in the stuck modes";
constexpr int restart = 150;             // where contacts open, shorter ones stagnate
constexpr double newton_accuracy = 1e-4; // relative; 1e-3 costs more Newton steps than it saves iterations
constexpr double rounding = 2 * std::numeric_limits<float>::epsilon(); // of a product, by the energy of the motion
constexpr PetscInt large = 1000; // dofs: with fewer, one Jacobian's coarse space costs more than it saves

} // namespace

ModalKrylov::ModalKrylov(const StuckBases &bases, const Layout &layout)
    : bases_(bases), layout_(layout), share_(bases, layout), own_(share_.own), own_modal_(own_.size() * layout.width),
      operator_(bases, layout, share_), coarse_(bases, layout, share_) {
  const PetscInt own = own_modal_ + (share_.holds_last ? 1 : 0);
  matrix_ = shell_matrix<&ModalKrylov::apply>(share_.comm, own, layout_.unknowns(), this, doing);
  check(MatCreateVecs(matrix_, right_.out(), answer_.out()), doing);
  check(KSPCreate(share_.comm, ksp_.out()), doing);
  check(KSPSetOptionsPrefix(ksp_, "hb_modal_"), doing);
  check(KSPSetOperators(ksp_, matrix_, matrix_), doing);
  check(KSPSetType(ksp_, KSPGMRES), doing);
  check(KSPGMRESSetRestart(ksp_, restart), doing);
  check(KSPSetPCSide(ksp_, PC_RIGHT), doing);
  check(KSPSetComputeEigenvalues(ksp_, PETSC_TRUE), doing);
  shell_preconditioner<&ModalKrylov::precondition>(ksp_, this, doing);
  check(KSPSetTolerances(ksp_, newton_accuracy, 0, 1e30, most_iterations), doing);
  check(KSPSetFromOptions(ksp_), doing);
  check(KSPGetTolerances(ksp_, &usual_accuracy_, nullptr, nullptr, &most_), doing);
}

void ModalKrylov::begin(bool for_one) {
  weights_.clear();
  coarse_.forget();
  coarse_due_ = !for_one || layout_.dofs() >= large;
}

void ModalKrylov::take(const JacobianParts &parts, Vec r) {
  structure_ = parts.structure;
  operator_.take(parts.contact, parts.held, structure_);
  const bool anew = std::exchange(coarse_due_, false) && coarse_.used();
  std::vector<float> matrix = anew ? coarse_.part(operator_, structure_) : std::vector<float>();
  prepare_border(parts, r, matrix);
  if (anew) coarse_.factor(std::move(matrix), structure_);
  prepare_inverse();
}

// Products with Phi_c and its transpose, and the vectors that GMRES keeps.
double ModalKrylov::work() const {
  return operator_.work() + 60.0 * layout_.width * static_cast<double>(layout_.dofs()) + 3e5;
}

bool ModalKrylov::solve(Vec r, Vec x, double accuracy, int most) {
  if (std::exchange(taken_, nullptr) != r) {
    const ReadValues from(r);
    const Values to(right_);
    const double last = layout_.owns_omega() ? from[layout_.own_coefficients()] : 0;
    std::vector<double> sums;
    if (share_.everywhere) sums = {last};
    std::vector<float> nothing;
    operator_.to_modes({{from, to}}, sums, nothing);
    if (share_.holds_last) to[own_modal_] = share_.everywhere ? sums[0] : last;
  }
  weigh(Values(right_));
  PetscInt count;
  KSPConvergedReason reason;
  check(KSPSetTolerances(ksp_, std::max(accuracy, best_accuracy), 0, 1e30, std::min<PetscInt>(most, most_)), doing);
  check(KSPSolve(ksp_, right_, answer_), doing);
  check(KSPGetIterationNumber(ksp_, &count), doing);
  check(KSPGetConvergedReason(ksp_, &reason), doing);
  count_ = static_cast<int>(count);
  bound_left();
  const ReadValues from(answer_);
  const Values to(x);
  operator_.from_modes(from, to);
  if (layout_.owns_omega()) to[layout_.own_coefficients()] = from[own_modal_];
  return reason > 0;
}

// GMRES in exact arithmetic leaves what it says. `spread` rounds the motion and Omega to single precision.
void ModalKrylov::bound_left() {
  PetscReal left, whole;
  check(KSPGetResidualNorm(ksp_, &left), doing);
  check(VecNorm(right_, NORM_2, &whole), doing);
  const ReadValues y(answer_);
  double energies[] = {0, share_.holds_last ? std::pow(y[own_modal_] * column_energy_, 2) : 0};
  for (PetscInt i = 0; i < own_modal_; ++i) energies[0] += std::pow(y[i] * roots_[i], 2);
  MPI_Allreduce(MPI_IN_PLACE, energies, 2, MPI_DOUBLE, MPI_SUM, share_.comm);
  left_ = whole > 0 ? (left + rounding * std::sqrt(energies[0] + energies[1])) / whole : 0;
}

void ModalKrylov::weigh(double *r) const {
  for (std::size_t i = 0; i < weights_.size(); ++i) r[i] *= weights_[i];
}

int ModalKrylov::sign() const { return ((coarse_.sign() < 0) != (schur_ < 0) ? -1 : 1) * sign_of_met(ksp_); }

int sign_of_met(KSP ksp) {
  KSPConvergedReason reason;
  PetscInt count, found;
  check(KSPGetConvergedReason(ksp, &reason), doing);
  check(KSPGetIterationNumber(ksp, &count), doing);
  if (reason <= 0 || count == 0 || count > restart) return 0;
  std::vector<double> real(count), imaginary(count);
  check(KSPComputeEigenvalues(ksp, count, real.data(), imaginary.data(), &found), doing);
  int sign = 1;
  for (PetscInt i = 0; i < found; ++i)
    if (imaginary[i] == 0 && real[i] < 0) sign = -sign;
  return sign;
}

// Diagonal blocks [a b; -b a] of each cosine-sine pair.
template <class Work> void ModalKrylov::pairs(Work &&work) {
  for (PetscInt i = 0; i < own_.size(); ++i) {
    for (int k = 0; k <= layout_.width / 2; ++k) {
      const StuckBasis &basis = bases_.of(k);
      const double lambda = basis.lambda[own_.begin + i], a = structure_.in_phase(k, lambda, 1),
                   b = structure_.quadrature(k, basis.damped[own_.begin + i], 1) +
                       basis.damper(structure_, k, own_.begin + i);
      const double square = std::max(a * a + b * b, 1e-20 * lambda * lambda); // no mode is undamped so exactly
      work(i * layout_.width + (k == 0 ? 0 : cosine(k)), k, a / square, b / square);
    }
  }
}

// The border stays the same all through Newton's method.
void ModalKrylov::prepare_border(const JacobianParts &parts, Vec r, std::vector<float> &matrix) {
  b_.resize(own_modal_), c_.resize(own_modal_);
  const std::vector<double> border(parts.border, parts.border + layout_.own_unknowns());
  const ReadValues from(r);
  const Values to(right_);
  const double *const column = parts.column;
  enum { right, corner, others };
  std::vector<double> sums(3);
  if (layout_.owns_omega()) sums[right] = from[layout_.own_coefficients()], sums[corner] = border.back();
  std::vector<ModalOperator::Forces> forces{{column, b_.data()}, {from, to}};
  const bool first = weights_.empty();
  if (first)
    forces.push_back({border.data(), c_.data()});
  else
    sums[others] = border != moved_border_;
  operator_.to_modes(forces, sums, matrix);
  std::vector<double> none;
  std::vector<float> nothing;
  if (!first && sums[others] > 0) operator_.to_modes({{border.data(), c_.data()}}, none, nothing);
  moved_border_ = border, taken_ = r;
  if (!share_.holds_last) return;
  to[own_modal_] = sums[right], corner_ = sums[corner];
}

// Those of the first Jacobian serve a whole Newton solve.
void ModalKrylov::prepare_weights() {
  const std::size_t all = own_modal_ + (share_.holds_last ? 1 : 0);
  roots_.resize(all), weights_.resize(all);
  for (PetscInt i = 0; i < own_.size(); ++i)
    for (int j = 0; j < layout_.width; ++j) {
      const int k = (j + 1) / 2;
      roots_[i * layout_.width + j] = std::sqrt(bases_.of(k).lambda[own_.begin + i] + structure_.inertia(k));
      weights_[i * layout_.width + j] = 1 / roots_[i * layout_.width + j];
    }
}

void ModalKrylov::prepare_inverse() {
  inverse_b_.resize(own_modal_), inverse_c_.resize(own_modal_);
  pairs([&](PetscInt at, int k, double a, double b) {
    if (k == 0) {
      inverse_b_[at] = a * b_[at], inverse_c_[at] = a * c_[at];
      return;
    }
    inverse_b_[at] = a * b_[at] - b * b_[at + 1], inverse_b_[at + 1] = b * b_[at] + a * b_[at + 1];
    inverse_c_[at] = a * c_[at] + b * c_[at + 1], inverse_c_[at + 1] = -b * c_[at] + a * c_[at + 1];
  });
  if (weights_.empty()) prepare_weights();
  const auto correct = [&](const std::vector<double> &v, std::vector<double> &inverse_v, bool transposed) {
    const PetscInt size = coarse_.size();
    if (size == 0) return;
    among_.resize(size);
    coarse_.to_motions(v.data(), among_.data());
    MPI_Allreduce(MPI_IN_PLACE, among_.data(), static_cast<int>(size), MPI_DOUBLE, MPI_SUM, share_.comm);
    coarse_.solve(among_.data(), transposed);
    coarse_.add(among_.data(), inverse_v.data());
  };
  correct(b_, inverse_b_, false), correct(c_, inverse_c_, true);
  double sums[] = {corner_ - std::inner_product(c_.begin(), c_.end(), inverse_b_.begin(), 0.0), 0, 0};
  for (PetscInt i = 0; i < own_modal_; ++i)
    sums[1] += std::pow(weights_[i] * b_[i], 2), sums[2] += std::pow(inverse_b_[i] * roots_[i], 2);
  MPI_Allreduce(MPI_IN_PLACE, sums, 3, MPI_DOUBLE, MPI_SUM, share_.comm);
  schur_ = sums[0] == 0 ? 1 : sums[0];
  column_energy_ = std::sqrt(sums[1]);
  // The motion along the curve, [-inverse_b_; 1] / schur_, answers to a last entry of 1: as large as its energy is,
  // what is left of a tangent's equations is relative to the tangent.
  const double size = std::sqrt(sums[1] + sums[2]) / std::abs(schur_);
  if (!share_.holds_last) return;
  weights_[own_modal_] = std::isnormal(size) ? size : 1;
  roots_[own_modal_] = 1 / weights_[own_modal_];
}

void ModalKrylov::apply(Vec y, Vec out) {
  const ReadValues in(y);
  const Values to(out);
  double last = share_.holds_last ? in[own_modal_] : 0,
         along = std::inner_product(c_.begin(), c_.end(), static_cast<const double *>(in), 0.0);
  operator_.apply(in, to, last, along);
  for (PetscInt i = 0; i < own_.size(); ++i) {
    const double *row = in + i * layout_.width;
    double *result = to + i * layout_.width;
    result[0] += bases_.mean().lambda[own_.begin + i] * row[0];
    for (int k = 1; k <= layout_.width / 2; ++k) {
      const StuckBasis &basis = bases_.of(k);
      const double lambda = basis.lambda[own_.begin + i], a = structure_.in_phase(k, lambda, 1),
                   b = structure_.quadrature(k, lambda, 1) + basis.damper(structure_, k, own_.begin + i);
      result[cosine(k)] += a * row[cosine(k)] + b * row[sine(k)];
      result[sine(k)] += a * row[sine(k)] - b * row[cosine(k)];
    }
  }
  for (PetscInt i = 0; i < own_modal_; ++i) to[i] = (to[i] + b_[i] * last) * weights_[i];
  if (share_.holds_last) to[own_modal_] = (along + corner_ * last) * weights_[own_modal_];
}

void ModalKrylov::precondition(Vec r, Vec out) {
  const ReadValues weighed(r);
  const Values to(out);
  forces_.resize(weights_.size());
  for (std::size_t i = 0; i < weights_.size(); ++i) forces_[i] = weighed[i] * roots_[i];
  const double *in = forces_.data();
  const PetscInt size = coarse_.size();
  among_.resize(size + 1);
  double &last = among_[size];
  coarse_.to_motions(in, among_.data());
  last = -std::inner_product(inverse_c_.begin(), inverse_c_.end(), in, 0.0);
  if (share_.holds_last) last += in[own_modal_];
  MPI_Allreduce(MPI_IN_PLACE, among_.data(), static_cast<int>(size + 1), MPI_DOUBLE, MPI_SUM, share_.comm);
  last /= schur_;
  pairs([&](PetscInt at, int k, double a, double b) {
    if (k == 0) {
      to[at] = a * in[at];
      return;
    }
    to[at] = a * in[at] - b * in[at + 1], to[at + 1] = b * in[at] + a * in[at + 1];
  });
  if (size > 0) coarse_.solve(among_.data(), false), coarse_.add(among_.data(), to);
  for (PetscInt i = 0; i < own_modal_; ++i) to[i] -= inverse_b_[i] * last;
  if (share_.holds_last) to[own_modal_] = last;
}

} // namespace dovetail
