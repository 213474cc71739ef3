#pragma once
// A Jacobian of the response with more unknowns behind Omega: its own entries, and as many more rows and columns.
#include <vector>

#include "stuck/layout.hpp"
#include "support/handle.hpp"

namespace dovetail {

class WiderMatrix {
public:
  /// `inner`: assembled, bordered, and filled once, so that its pattern is known. Collective.
  WiderMatrix(const Layout &layout, Mat inner, int more);

  Mat get() const { return matrix_; }
  /// Columns and rows: (own unknowns of the inner one) each; corner: (more, more) row-major, of the last rank.
  /// Harmonics of the motion, and of its equations, are in units of `swing`, means are not. Collective.
  void fill(Mat inner, const std::vector<const double *> &columns, const std::vector<const double *> &rows,
            const double *corner, double swing = 1);

private:
  template <class Act> void for_each_row(Mat inner, Act &&act) const;

  const Layout &layout_;
  int more_;
  UniqueMat matrix_;
  std::vector<double> values_; // in the order given to the matrix
};

} // namespace dovetail
