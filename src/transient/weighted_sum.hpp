#pragma once
// The products that time integration spends its time in.

namespace dovetail {

/// out (columns) = sum over the rows of weights (rows) times table (rows, columns). Quick where the columns are a
/// multiple of eight.
void combine(int rows, int columns, const double *weights, const double *table, double *out);

/// Row i of out (rows, columns) = -share times: w2[i] (now + by_stiffness then) + by_mass then, of rows, and the sum
/// over `pulled` of weights (pulled, stride)[., i] times table (pulled, columns).
struct NextTerm {
  int rows, columns, pulled, stride;
  const double *w2, *weights;
};
void next_term(const NextTerm &of, double share, double by_stiffness, double by_mass, const double *now,
               const double *then, const double *table, double *out);

/// y (count) += a x.
void add_scaled(int count, double a, const double *x, double *y);

/// y (count) = x + a y.
void scale_and_add(int count, double a, const double *x, double *y);

double largest_of(int count, const double *x); ///< |x|

} // namespace dovetail
