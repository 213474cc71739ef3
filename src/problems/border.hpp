#pragma once
// Square matrices with a few more columns and rows, [A C; R D], by products and by elimination of the border; A is
// multiplied and solved with elsewhere. A vector has the own coefficients of every rank, then the border's entries on
// the last one.
#include <algorithm>
#include <array>
#include <numeric>
#include <vector>

#include "stuck/layout.hpp"
#include "support/dense.hpp"

namespace dovetail {

template <int width> class Border {
public:
  using Last = std::array<double, width>;

  explicit Border(const Layout &layout) : layout_(layout) {}

  std::array<std::vector<double>, width> columns, rows; ///< (own coefficients) each
  std::array<Last, width> corner{};                     ///< D by rows, on every rank

  PetscInt own() const { return layout_.own_coefficients() + (layout_.owns_omega() ? width : 0); }
  PetscInt all() const { return layout_.dofs() * layout_.width + width; }

  /// The border's entries of x, on every rank. Collective.
  Last last_of(const double *x) const {
    Last last{};
    if (layout_.owns_omega()) std::copy_n(x + layout_.own_coefficients(), width, last.begin());
    MPI_Bcast(last.data(), width, MPI_DOUBLE, layout_.size - 1, layout_.comm);
    return last;
  }

  /// y += C last; its border's entries become those of [R D] x. Collective.
  void multiply(const double *x, const Last &last, double *y) const {
    const Last sums = along_rows(x);
    for (int b = 0; b < width; ++b) add(last[b], columns[b], y);
    if (!layout_.owns_omega()) return;
    for (int a = 0; a < width; ++a)
      y[layout_.own_coefficients() + a] = std::inner_product(last.begin(), last.end(), corner[a].begin(), sums[a]);
  }

  /// Prepares `solve` by answers to the columns; `inverse(r, x)` gives x = A^-1 r, or false. `first`: the answer to the
  /// first column, where it is known. False where an answer fails, or D - R A^-1 C is singular. Collective.
  template <class Inverse> bool eliminate(Inverse &&inverse, const std::vector<double> *first = nullptr) {
    Dense left(width, width);
    regular_ = false;
    for (int b = 0; b < width; ++b) {
      answers_[b].resize(layout_.own_coefficients());
      if (b == 0 && first)
        answers_[b] = *first;
      else if (!inverse(columns[b].data(), answers_[b].data()))
        return false;
      const Last sums = along_rows(answers_[b].data());
      for (int a = 0; a < width; ++a) left(a, b) = corner[a][b] - sums[a];
    }
    return regular_ = factors_.factor(left);
  }

  /// x = [A C; R D]^-1 r, or [A^-1 r; 0] where the border was not eliminated. False where `inverse` fails. Collective.
  template <class Inverse> bool solve(Inverse &&inverse, const double *r, double *x) const {
    Last last = last_of(r);
    if (!inverse(r, x)) return false;
    const Last sums = along_rows(x);
    std::transform(last.begin(), last.end(), sums.begin(), last.begin(), std::minus());
    if (regular_)
      factors_.solve(last.data());
    else
      last.fill(0);
    for (int b = 0; b < width; ++b) add(-last[b], answers_[b], x);
    if (layout_.owns_omega()) std::copy_n(last.begin(), width, x + layout_.own_coefficients());
    return true;
  }

  /// Of det (D - R A^-1 C).
  int sign() const { return factors_.sign(); }

private:
  Last along_rows(const double *x) const {
    Last sums{};
    for (int b = 0; b < width; ++b) sums[b] = std::inner_product(rows[b].begin(), rows[b].end(), x, 0.0);
    MPI_Allreduce(MPI_IN_PLACE, sums.data(), width, MPI_DOUBLE, MPI_SUM, layout_.comm);
    return sums;
  }

  static void add(double factor, const std::vector<double> &v, double *y) {
    for (std::size_t i = 0; i < v.size(); ++i) y[i] += factor * v[i];
  }

  const Layout &layout_;
  std::array<std::vector<double>, width> answers_; // A^-1 C
  Factors factors_;                                // of D - R A^-1 C
  bool regular_ = false;
};

} // namespace dovetail
