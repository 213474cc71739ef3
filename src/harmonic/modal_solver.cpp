#include "harmonic/modal_solver.hpp"

#include <cmath>
#include <numeric>

namespace dovetail {
namespace {

constexpr const char *doing = "solving in the stuck modes";
constexpr int restart = 60, most_iterations = 300;
constexpr PetscInt most_assembled = 6000; // unknowns of a matrix that is factored for the sign of its determinant
constexpr double newton_accuracy = 1e-4;  // relative; 1e-3 costs more Newton steps than it saves iterations
constexpr double single_accuracy = 1e-6;  // what a round in single precision can reach

class Values { // of a vector, own share
public:
  explicit Values(Vec v) : v_(v) { check(VecGetArray(v_, &values_), doing); }
  Values(const Values &) = delete;
  ~Values() { VecRestoreArray(v_, &values_); }
  operator double *() const { return values_; }

private:
  Vec v_;
  double *values_;
};

class ReadValues {
public:
  explicit ReadValues(Vec v) : v_(v) { check(VecGetArrayRead(v_, &values_), doing); }
  ReadValues(const ReadValues &) = delete;
  ~ReadValues() { VecRestoreArrayRead(v_, &values_); }
  operator const double *() const { return values_; }

private:
  Vec v_;
  const double *values_;
};

} // namespace

ModalSolver::ModalSolver(std::shared_ptr<const StuckBasis> basis, const Layout &layout)
    : basis_(std::move(basis)), layout_(layout), own_(own_share(layout.comm, layout.dofs())),
      own_modal_(own_.size() * layout.width), operator_(*basis_, layout) {
  const PetscInt own = own_modal_ + (layout_.owns_omega() ? 1 : 0);
  check(MatCreateShell(layout_.comm, own, own, layout_.unknowns(), layout_.unknowns(), this, matrix_.out()), doing);
  const auto apply_in_modes = +[](Mat A, Vec y, Vec out) -> PetscErrorCode {
    void *self;
    MatShellGetContext(A, &self);
    auto &solver = *static_cast<ModalSolver *>(self);
    return solver.run([&] { solver.apply(y, out); });
  };
  check(MatShellSetOperation(matrix_, MATOP_MULT, reinterpret_cast<void (*)()>(apply_in_modes)), doing);
  check(MatCreateVecs(matrix_, right_.out(), answer_.out()), doing);
  for (UniqueVec *v : {&remainder_, &correction_})
    check(VecCreateMPI(layout_.comm, layout_.own_unknowns(), layout_.unknowns(), v->out()), doing);
  check(KSPCreate(layout_.comm, krylov_.out()), doing);
  check(KSPSetOptionsPrefix(krylov_, "hb_modal_"), doing);
  check(KSPSetOperators(krylov_, matrix_, matrix_), doing);
  check(KSPSetType(krylov_, KSPGMRES), doing);
  check(KSPGMRESSetRestart(krylov_, restart), doing);
  check(KSPSetComputeEigenvalues(krylov_, PETSC_TRUE), doing);
  PC pc;
  check(KSPGetPC(krylov_, &pc), doing);
  check(PCSetType(pc, PCSHELL), doing);
  check(PCShellSetContext(pc, this), doing);
  check(PCShellSetApply(pc,
                        [](PC shell, Vec r, Vec out) -> PetscErrorCode {
                          void *self;
                          PCShellGetContext(shell, &self);
                          auto &solver = *static_cast<ModalSolver *>(self);
                          return solver.run([&] { solver.precondition(r, out); });
                        }),
        doing);
  check(KSPSetTolerances(krylov_, newton_accuracy, 0, 1e30, most_iterations), doing);
  check(KSPSetFromOptions(krylov_), doing);
  check(KSPGetTolerances(krylov_, &newton_accuracy_, nullptr, nullptr, &most_iterations_), doing);
}

void ModalSolver::fill(const JacobianParts &parts, LinearPart &linear) {
  contact_ = &parts.contact, linear_ = &linear;
  omega_ = parts.omega, damping_ = parts.damping;
  held_.clear();
  if (parts.held) held_.assign(parts.held, parts.held + 3 * layout_.own_points.size());
  column_.assign(parts.column, parts.column + layout_.own_coefficients());
  border_.assign(parts.border, parts.border + layout_.own_coefficients());
  corner_ = layout_.owns_omega() ? parts.border[layout_.own_coefficients()] : 0;
  stale_ = true;
}

void ModalSolver::multiply(Vec x, Vec y) {
  const int n = layout_.width;
  const PetscInt count = layout_.own_coefficients(), contact = layout_.own_point_offset(0);
  const ReadValues in(x);
  const Values out(y);
  double last = layout_.owns_omega() ? in[count] : 0;
  MPI_Bcast(&last, 1, MPI_DOUBLE, layout_.size - 1, layout_.comm);
  stiff_.resize(count), heavy_.resize(count), force_.resize(count - contact);
  linear_->multiply(in, stiff_.data(), heavy_.data());
  contact_->multiply(in + contact, force_.data());
  double along = std::inner_product(border_.begin(), border_.end(), static_cast<const double *>(in), 0.0);
  MPI_Allreduce(MPI_IN_PLACE, &along, 1, MPI_DOUBLE, MPI_SUM, layout_.comm);
  for (PetscInt i = 0; i < count; ++i) {
    const int place = static_cast<int>(i % n), k = (place + 1) / 2;
    const double cross = place == 0 ? 0 : place % 2 ? stiff_[i + 1] : -stiff_[i - 1];
    out[i] = stiff_[i] - k * omega_ * k * omega_ * heavy_[i] + k * omega_ * damping_ * cross + column_[i] * last;
    if (i >= contact) out[i] += force_[i - contact];
    if (i >= contact && place == 0 && !held_.empty()) out[i] += held_[(i - contact) / n] * in[i];
  }
  if (layout_.owns_omega()) out[count] = along + corner_ * last;
}

void ModalSolver::set_up(KSP ksp, Mat J) {
  outer_ = ksp;
  check(KSPSetOperators(ksp, J, J), doing);
  check(KSPSetType(ksp, KSPPREONLY), doing);
  PC pc;
  check(KSPGetPC(ksp, &pc), doing);
  check(PCSetType(pc, PCSHELL), doing);
  check(PCShellSetContext(pc, this), doing);
  check(PCShellSetApply(pc,
                        [](PC shell, Vec r, Vec x) -> PetscErrorCode {
                          void *self;
                          PCShellGetContext(shell, &self);
                          auto &solver = *static_cast<ModalSolver *>(self);
                          return solver.run([&] { solver.solve(r, x); });
                        }),
        doing);
}

// Diagonal blocks [a b; -b a] of each cosine-sine pair.
template <class Work> void ModalSolver::pairs(Work &&work) {
  for (PetscInt i = 0; i < own_.size(); ++i) {
    const double lambda = basis_->lambda[own_.begin + i], damped = basis_->damped[own_.begin + i];
    for (int k = 0; k <= layout_.width / 2; ++k) {
      const double a = lambda - k * omega_ * k * omega_, b = k * omega_ * damping_ * damped;
      const double square = std::max(a * a + b * b, 1e-20 * lambda * lambda); // no mode is undamped so exactly
      work(i * layout_.width + (k == 0 ? 0 : cosine(k)), k, a / square, b / square);
    }
  }
}

void ModalSolver::prepare_diagonal() {
  b_.resize(own_modal_), c_.resize(own_modal_);
  operator_.to_modes(column_.data(), b_.data());
  int same = border_ == moved_border_; // it stays the same all through Newton's method
  if (layout_.size > 1) MPI_Allreduce(MPI_IN_PLACE, &same, 1, MPI_INT, MPI_LAND, layout_.comm);
  if (!same) operator_.to_modes(border_.data(), c_.data()), moved_border_ = border_;
  inverse_b_.resize(own_modal_), inverse_c_.resize(own_modal_);
  pairs([&](PetscInt at, int k, double a, double b) {
    if (k == 0) {
      inverse_b_[at] = a * b_[at], inverse_c_[at] = a * c_[at];
      return;
    }
    inverse_b_[at] = a * b_[at] - b * b_[at + 1], inverse_b_[at + 1] = b * b_[at] + a * b_[at + 1];
    inverse_c_[at] = a * c_[at] + b * c_[at + 1], inverse_c_[at + 1] = -b * c_[at] + a * c_[at + 1];
  });
  schur_ = corner_ - std::inner_product(c_.begin(), c_.end(), inverse_b_.begin(), 0.0);
  MPI_Allreduce(MPI_IN_PLACE, &schur_, 1, MPI_DOUBLE, MPI_SUM, layout_.comm);
  if (schur_ == 0) schur_ = 1;
}

void ModalSolver::solve(Vec r, Vec x) {
  PetscReal asked;
  check(KSPGetTolerances(outer_, &asked, nullptr, nullptr, nullptr), doing);
  if (asked >= 0.5) asked = newton_accuracy_;
  if (std::exchange(stale_, false)) {
    operator_.take(*contact_, held_.empty() ? nullptr : held_.data(), omega_ * damping_);
    prepare_diagonal();
  }
  solve_roughly(r, std::max(asked, single_accuracy));
  check(VecCopy(correction_, x), doing);
  first_sign_.reset();
  for (double reached = single_accuracy; reached > asked; reached *= single_accuracy) {
    if (!first_sign_) first_sign_ = sign_by_krylov(); // the rounds to come are short and meet few eigenvalues
    multiply(x, remainder_);
    check(VecAYPX(remainder_, -1, r), doing);
    solve_roughly(remainder_, std::max(asked / reached, single_accuracy));
    check(VecAXPY(x, 1, correction_), doing);
  }
}

void ModalSolver::solve_roughly(Vec r, double accuracy) {
  {
    const ReadValues from(r);
    const Values to(right_);
    operator_.to_modes(from, to);
    if (layout_.owns_omega()) to[own_modal_] = from[layout_.own_coefficients()];
  }
  check(KSPSetTolerances(krylov_, accuracy, 0, 1e30, most_iterations_), doing);
  check(KSPSolve(krylov_, right_, answer_), doing);
  PetscInt count;
  check(KSPGetIterationNumber(krylov_, &count), doing);
  krylov_count_ = static_cast<int>(count);
  iterations_ += krylov_count_;
  const ReadValues from(answer_);
  const Values to(correction_);
  operator_.from_modes(from, to);
  if (layout_.owns_omega()) to[layout_.own_coefficients()] = from[own_modal_];
}

int ModalSolver::determinant_sign() {
  if (layout_.unknowns() > most_assembled) return 0;
  const int sign = first_sign_ ? *first_sign_ : sign_by_krylov();
  return sign_ = sign != 0 && (sign_ == 0 || sign == sign_) ? sign : sign_by_factors();
}

int ModalSolver::sign_by_krylov() const {
  KSPConvergedReason reason;
  check(KSPGetConvergedReason(krylov_, &reason), doing);
  if (reason <= 0 || krylov_count_ == 0 || krylov_count_ > restart) return 0;
  std::vector<double> real(krylov_count_), imaginary(krylov_count_);
  PetscInt found;
  check(KSPComputeEigenvalues(krylov_, krylov_count_, real.data(), imaginary.data(), &found), doing);
  int sign = schur_ < 0 ? -1 : 1;
  for (PetscInt i = 0; i < found; ++i)
    if (imaginary[i] == 0 && real[i] < 0) sign = -sign;
  return sign;
}

int ModalSolver::sign_by_factors() {
  if (!twin_) {
    twin_.reset(new Twin{Assembled(linear_->couplings(), layout_), {}, {}});
    twin_->matrix = twin_->form.matrix(*contact_);
    check(KSPCreate(layout_.comm, twin_->ksp.out()), doing);
    twin_->form.set_up(twin_->ksp, twin_->matrix);
  }
  border_.push_back(corner_);
  twin_->form.fill(twin_->matrix, {omega_, damping_, *contact_, held_.empty() ? nullptr : held_.data(), column_.data(),
                                   border_.data()});
  border_.pop_back();
  check(KSPSetOperators(twin_->ksp, twin_->matrix, twin_->matrix), doing);
  check(KSPSetUp(twin_->ksp), doing);
  const int sign = twin_->form.determinant_sign(twin_->ksp);
  if (sign == 0) twin_->form.recover(twin_->ksp, twin_->matrix);
  return sign;
}

void ModalSolver::apply(Vec y, Vec out) {
  const ReadValues in(y);
  const Values to(out);
  double last = layout_.owns_omega() ? in[own_modal_] : 0,
         along = std::inner_product(c_.begin(), c_.end(), static_cast<const double *>(in), 0.0);
  operator_.apply(in, to, last, along);
  for (PetscInt i = 0; i < own_.size(); ++i) {
    const double lambda = basis_->lambda[own_.begin + i];
    const double *row = in + i * layout_.width;
    double *result = to + i * layout_.width;
    result[0] += lambda * row[0];
    for (int k = 1; k <= layout_.width / 2; ++k) {
      const double a = lambda - k * omega_ * k * omega_, b = k * omega_ * damping_ * lambda;
      result[cosine(k)] += a * row[cosine(k)] + b * row[sine(k)];
      result[sine(k)] += a * row[sine(k)] - b * row[cosine(k)];
    }
  }
  for (PetscInt i = 0; i < own_modal_; ++i) to[i] += b_[i] * last;
  if (layout_.owns_omega()) to[own_modal_] = along + corner_ * last;
}

void ModalSolver::precondition(Vec r, Vec out) {
  const ReadValues in(r);
  const Values to(out);
  double last = -std::inner_product(inverse_c_.begin(), inverse_c_.end(), static_cast<const double *>(in), 0.0);
  if (layout_.owns_omega()) last += in[own_modal_];
  if (layout_.size > 1) MPI_Allreduce(MPI_IN_PLACE, &last, 1, MPI_DOUBLE, MPI_SUM, layout_.comm);
  last /= schur_;
  pairs([&](PetscInt at, int k, double a, double b) {
    if (k == 0) {
      to[at] = a * in[at];
      return;
    }
    to[at] = a * in[at] - b * in[at + 1], to[at + 1] = b * in[at] + a * in[at + 1];
  });
  for (PetscInt i = 0; i < own_modal_; ++i) to[i] -= inverse_b_[i] * last;
  if (layout_.owns_omega()) to[own_modal_] = last;
}

} // namespace dovetail
