#pragma once
// The bordered Jacobian factored in modes of the structure (docs/theory/stuck-modes.md). There it is diagonal, D, but
// for the contacts, whose part Delta has few rows or can be written with few:
//     (D + Phi_c^H Delta Phi_c)^-1 = D^-1 - D^-1 Phi_c^H Delta (I + F Delta)^-1 Phi_c D^-1,   F = Phi_c D^-1 Phi_c^H.
// What I + F Delta is like depends on the basis: contact_factors.hpp, window_factors.hpp. Every rank factors and solves
// the same.
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "modal/index_groups.hpp"
#include "modal/linear_part.hpp"
#include "stuck/stuck_basis.hpp"
#include "support/gathered.hpp"

namespace dovetail {

/// C (m, n) = A B + beta C by columns, with op(A) (m, k), op(B) (k, n).
void gemm(const char *ta, const char *tb, std::size_t m, std::size_t n, std::size_t k, const double *A, std::size_t lda,
          const double *B, std::size_t ldb, double beta, double *C, std::size_t ldc);

/// `all` = what the ranks have, one after the other. Collective.
template <class T> void gather(const Layout &layout, std::vector<T> own, std::vector<T> &all, MPI_Datatype type) {
  all = layout.size == 1 ? std::move(own) : gathered(layout.comm, type, own);
}

/// LAPACK's factors of a square row-major matrix, in its place; the sign of its determinant, 0 where it is singular.
int factor_in_place(std::vector<double> &matrix, std::vector<PetscBLASInt> &pivots);
/// x = what such factors are the matrix of, to the power of -1, times x.
void solve_in_place(const std::vector<double> &factors, const std::vector<PetscBLASInt> &pivots, double *x);

class ModalFactors {
public:
  virtual ~ModalFactors() = default;
  virtual PetscInt size() const = 0;        ///< of what LAPACK is given
  virtual double work() const = 0;          ///< to factor, in operations in single precision that take as long
  virtual double work_to_solve() const = 0; ///< once, likewise
  virtual bool exact() const = 0;           ///< what was factored, if it is the Jacobian still,
  virtual bool tells_sign() const = 0;      ///< or well enough for the determinant's sign

  /// `precisely`: in double precision in any case. False: singular, or no number. Collective.
  bool factor(const JacobianParts &parts, bool precisely = false);
  void forget() { sign_ = 0; }
  bool factored() const { return sign_ != 0; }
  /// x = inverse times r, (own unknowns) both. Collective.
  void solve(const double *r, double *x);
  int determinant_sign() const { return sign_; } ///< of what was factored

protected:
  /// `bases` must outlive this.
  ModalFactors(const StuckBases &bases, const Layout &layout);

  /// I + F Delta, factored; the sign of its determinant. `rows_`, `own_` and `other_` are there. Collective.
  virtual int decompose(const JacobianParts &parts, bool precisely) = 0;
  /// force_ = -Delta (I + F Delta)^-1 motion_.
  virtual void react() = 0;

  void count_moving(std::optional<double> told); // rows_, from moving_ of all ranks or as told
  void share_moving();                           // all_moving_, from moving_
  /// F of a harmonic, (rows, rows) each, by rows; k = 0: one.
  void flexibility(int k, double *in_phase, double *out_of_phase);

  double length() const { return static_cast<double>(sheaves_.back().length); } // of a row of Phi_c, the longest

  const StuckBases &bases_;
  const StuckBasis &basis_; // of the mean
  Layout layout_;
  std::size_t n_;                    // modes of a basis
  std::vector<int> moving_;          // own contact dofs that Delta has rows of
  PetscInt rows_ = 0;                // how many these are on all ranks
  bool shared_ = false;              // all_moving_ is of these
  std::vector<PetscInt> all_moving_; // those of all ranks, by number
  std::vector<PetscInt> factored_;   // those that were factored, from here on `rows`
  DynamicStiffness structure_;
  std::vector<double> motion_, force_; // (rows, 2H+1)

private:
  void gather_rows();
  void weigh();
  void to_modes(const std::vector<std::pair<const double *, std::vector<double> *>> &forces, double &last) const;
  void solve_in_modes(std::vector<double> &y);

  struct Sheaf { // harmonics that share a basis
    IndexGroup of;
    const StuckBasis &basis;
    std::size_t length;       // of a row of Phi: n, or twice that if complex
    std::vector<double> rows; // (rows, length) Phi_c of those that were factored
  };
  void move(const Sheaf &of, std::size_t rows, const double *phi, std::size_t stride, const double *y, double *q) const;
  void press(const Sheaf &of, std::size_t rows, const double *phi, std::size_t stride, const double *f,
             double *y) const;

  std::vector<Sheaf> sheaves_;
  std::vector<double> own_, other_; // (n, H+1) D^-1 = [own, -other; other, own] of a mode and harmonic
  std::vector<double> scaled_;      // (rows, length)
  std::vector<double> b_, c_;       // (n, 2H+1) the inverse times the border's column; its row
  std::vector<double> y_;
  double schur_ = 1;
  int sign_ = 0;
};

} // namespace dovetail
