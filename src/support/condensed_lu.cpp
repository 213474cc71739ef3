#include "support/condensed_lu.hpp"

#include <petscsys.h>

#include <petscblaslapack.h>

#include <cmath>
#include <vector>

#include "support/error.hpp"

namespace dovetail {
namespace {

struct Entry {
  PetscInt place;
  double value;
};

// [A B; C D], A of blocks with one or two rows: D - C A^-1 B is factored.
class Factors {
public:
  Factors(PetscInt leading, PetscInt width) : leading_(leading), width_(width) {}

  void factor(PetscInt n, const PetscInt *starts, const PetscInt *columns, const double *entries);
  void solve(const double *b, double *x);
  int sign() const { return sign_; }

private:
  PetscInt partner(PetscInt i) const { // of the same block
    const PetscInt k = i % width_;
    return k == 0 ? i : k % 2 == 1 ? i + 1 : i - 1;
  }
  void eliminate();
  void condense(PetscInt n, const PetscInt *starts, const PetscInt *columns, const double *entries);

  PetscInt leading_, width_;
  std::vector<double> own_, other_;  // (leading) of A: on the diagonal, and beside it; then of its inverse
  std::vector<Entry> right_;         // rows of A^-1 B, one after the other
  std::vector<std::size_t> ends_;    // (leading) of these rows
  std::vector<Entry> below_;         // rows of C
  std::vector<std::size_t> last_;    // (rest) ends of these rows
  std::vector<double> rest_;         // (rest, rest) factors of D - C A^-1 B, its rows as LAPACK's columns
  std::vector<PetscBLASInt> pivots_; // (rest)
  std::vector<double> image_;        // (leading) A^-1 b
  int sign_ = 0;                     // of the determinant
};

void Factors::factor(PetscInt n, const PetscInt *starts, const PetscInt *columns, const double *entries) {
  own_.assign(leading_, 0), other_.assign(leading_, 0);
  for (PetscInt i = 0; i < leading_; ++i)
    for (PetscInt e = starts[i]; e < starts[i + 1] && columns[e] < leading_; ++e)
      (columns[e] == i ? own_ : other_)[i] = entries[e];
  sign_ = 1;
  eliminate();
  condense(n, starts, columns, entries);
  PetscBLASInt size = static_cast<PetscBLASInt>(n - leading_), info;
  pivots_.resize(size);
  LAPACKgetrf_(&size, &size, rest_.data(), &size, pivots_.data(), &info);
  if (info != 0) sign_ = 0;
  for (PetscBLASInt i = 0; i < size; ++i) {
    if (rest_[i + static_cast<std::size_t>(i) * size] < 0) sign_ = -sign_;
    if (pivots_[i] != i + 1) sign_ = -sign_;
  }
}

// A becomes its inverse.
void Factors::eliminate() {
  for (PetscInt i = 0; i < leading_; ++i) {
    const PetscInt j = partner(i);
    if (j < i) continue;
    const double determinant = j == i ? own_[i] : own_[i] * own_[j] - other_[i] * other_[j];
    if (!(std::abs(determinant) > 0)) sign_ = 0;
    if (determinant < 0) sign_ = -sign_;
    if (j == i) {
      own_[i] = 1 / determinant;
    } else {
      std::swap(own_[i], own_[j]);
      for (double *value : {&own_[i], &own_[j]}) *value /= determinant;
      for (double *value : {&other_[i], &other_[j]}) *value /= -determinant;
    }
  }
}

void Factors::condense(PetscInt n, const PetscInt *starts, const PetscInt *columns, const double *entries) {
  right_.clear(), ends_.clear(), below_.clear(), last_.clear();
  for (PetscInt i = 0; i < leading_; ++i) {
    const PetscInt j = partner(i);
    for (const auto &[row, factor] : {std::pair{i, own_[i]}, std::pair{j, j == i ? 0 : other_[i]}})
      for (PetscInt e = starts[row]; factor != 0 && e < starts[row + 1]; ++e)
        if (columns[e] >= leading_) right_.push_back({columns[e] - leading_, factor * entries[e]});
    ends_.push_back(right_.size());
  }
  const PetscInt size = n - leading_;
  rest_.assign(static_cast<std::size_t>(size) * size, 0);
  for (PetscInt i = leading_; i < n; ++i) {
    double *row = &rest_[static_cast<std::size_t>(i - leading_) * size];
    for (PetscInt e = starts[i]; e < starts[i + 1]; ++e) {
      const PetscInt j = columns[e];
      if (j >= leading_) {
        row[j - leading_] += entries[e];
        continue;
      }
      below_.push_back({j, entries[e]});
      for (std::size_t r = j == 0 ? 0 : ends_[j - 1]; r < ends_[j]; ++r)
        row[right_[r].place] -= entries[e] * right_[r].value;
    }
    last_.push_back(below_.size());
  }
}

void Factors::solve(const double *b, double *x) {
  const PetscBLASInt size = static_cast<PetscBLASInt>(pivots_.size()), one = 1;
  image_.resize(leading_);
  for (PetscInt i = 0; i < leading_; ++i)
    image_[i] = own_[i] * b[i] + (partner(i) == i ? 0 : other_[i] * b[partner(i)]);
  double *rest = x + leading_;
  for (PetscBLASInt i = 0; i < size; ++i) {
    rest[i] = b[leading_ + i];
    for (std::size_t e = i == 0 ? 0 : last_[i - 1]; e < last_[i]; ++e)
      rest[i] -= below_[e].value * image_[below_[e].place];
  }
  PetscBLASInt info;
  LAPACKgetrs_("T", &size, &one, rest_.data(), &size, pivots_.data(), rest, &size, &info);
  for (PetscInt i = 0; i < leading_; ++i) {
    x[i] = image_[i];
    for (std::size_t e = i == 0 ? 0 : ends_[i - 1]; e < ends_[i]; ++e) x[i] -= right_[e].value * rest[right_[e].place];
  }
}

Factors &of(PC pc) {
  void *context;
  check(PCShellGetContext(pc, &context), "reaching a factor");
  return *static_cast<Factors *>(context);
}

PetscErrorCode set_up(PC pc) {
  Factors &factors = of(pc);
  Mat A;
  PetscInt n, none;
  PetscBool done;
  const PetscInt *starts, *columns;
  const double *entries;
  PetscCall(PCGetOperators(pc, nullptr, &A));
  PetscCall(MatGetRowIJ(A, 0, PETSC_FALSE, PETSC_FALSE, &n, &starts, &columns, &done));
  PetscCall(MatSeqAIJGetArrayRead(A, &entries));
  factors.factor(n, starts, columns, entries);
  PetscCall(MatSeqAIJRestoreArrayRead(A, &entries));
  PetscCall(MatRestoreRowIJ(A, 0, PETSC_FALSE, PETSC_FALSE, &none, &starts, &columns, &done));
  PetscCall(PCSetFailedReason(pc, factors.sign() != 0 ? PC_NOERROR : PC_FACTOR_NUMERIC_ZEROPIVOT));
  return 0;
}

PetscErrorCode apply(PC pc, Vec b, Vec x) {
  const double *from;
  double *to;
  PetscCall(VecGetArrayRead(b, &from));
  PetscCall(VecGetArrayWrite(x, &to));
  of(pc).solve(from, to);
  PetscCall(VecRestoreArrayWrite(x, &to));
  PetscCall(VecRestoreArrayRead(b, &from));
  return 0;
}

PetscErrorCode forget(PC pc) {
  delete &of(pc);
  return 0;
}

} // namespace

void factor_condensed(KSP ksp, Mat A, PetscInt leading, PetscInt width) {
  PC pc;
  check(KSPSetOperators(ksp, A, A), "setting up LAPACK");
  check(KSPSetType(ksp, KSPPREONLY), "setting up LAPACK");
  check(KSPGetPC(ksp, &pc), "setting up LAPACK");
  check(PCSetType(pc, PCSHELL), "setting up LAPACK");
  check(PCShellSetName(pc, "modes eliminated, dense LU"), "setting up LAPACK");
  check(PCShellSetContext(pc, new Factors(leading, width)), "setting up LAPACK");
  check(PCShellSetDestroy(pc, forget), "setting up LAPACK");
  check(PCShellSetSetUp(pc, set_up), "setting up LAPACK");
  check(PCShellSetApply(pc, apply), "setting up LAPACK");
}

bool is_condensed(KSP ksp) {
  PC pc;
  PetscBool same;
  check(KSPGetPC(ksp, &pc), "asking for the solver");
  check(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(pc), PCSHELL, &same), "asking for the solver");
  return same;
}

int condensed_determinant_sign(KSP ksp) {
  PC pc;
  check(KSPGetPC(ksp, &pc), "asking for a determinant");
  return of(pc).sign();
}

} // namespace dovetail
