#pragma once
// The product that time integration spends its time in.

namespace dovetail {

/// out (columns) = sum over the rows of weights (rows) times table (rows, columns). Quick where the columns are a
/// multiple of eight.
void combine(int rows, int columns, const double *weights, const double *table, double *out);

} // namespace dovetail
