#include "transient/free_modes.hpp"

#include <slepcblaslapack.h>

#include <algorithm>

#include "contact/wide.hpp"
#include "support/error.hpp"

namespace dovetail {
namespace {

DOVETAIL_WIDE void combine_wide(int rows, int columns, const double *weights, const double *table, double *out) {
  std::fill_n(out, columns, 0.0);
  int i = 0;
  for (; i + 4 <= rows; i += 4, table += 4 * columns) { // four at a time: fewer passes over `out`
    const double a = weights[i], b = weights[i + 1], c = weights[i + 2], d = weights[i + 3];
    const double *A = table, *B = A + columns, *C = B + columns, *D = C + columns;
    for (int j = 0; j < columns; ++j) out[j] += (a * A[j] + b * B[j]) + (c * C[j] + d * D[j]);
  }
  for (; i < rows; ++i, table += columns)
    for (int j = 0; j < columns; ++j) out[j] += weights[i] * table[j];
}

} // namespace

FreeModes free_modes(const DenseModel &model) {
  const int n = model.dofs(), m = 3 * model.points;
  FreeModes out;
  out.count = n;
  out.shapes = model.K;
  out.w2.resize(n);
  std::vector<double> M = model.M, work(1);
  PetscBLASInt size = n, type = 1, lwork = -1, info = 0;
  for (int pass = 0; pass < 2 && n > 0; ++pass) { // the first one asks for the size of the workspace
    LAPACKsygv_(&type, "V", "L", &size, out.shapes.data(), &size, M.data(), &size, out.w2.data(), work.data(), &lwork,
                &info);
    if (info != 0)
      throw ComputeError("time integration: the reduced mass matrix is not positive definite (LAPACK's sygv: " +
                         std::to_string(info) + ")");
    lwork = static_cast<PetscBLASInt>(work[0]);
    work.resize(lwork);
  }
  for (double &w2 : out.w2) w2 = std::max(w2, 0.0); // rigid motion, to round-off
  const double *shapes = out.shapes.data();         // column-major: mode after mode
  out.contact.resize(static_cast<std::size_t>(n) * m);
  out.participation.resize(out.contact.size());
  out.momentum.resize(out.shapes.size());
  out.force.resize(n);
  for (int i = 0; i < n; ++i) {
    const double *shape = shapes + static_cast<std::size_t>(i) * n;
    for (int j = 0; j < n; ++j) out.force[i] += shape[j] * model.force[j];
    for (int c = 0; c < m; ++c) {
      out.contact[static_cast<std::size_t>(i) * m + c] = shape[model.modes + c];
      out.participation[static_cast<std::size_t>(c) * n + i] = shape[model.modes + c];
    }
    combine(n, n, shape, model.M.data(), &out.momentum[static_cast<std::size_t>(i) * n]);
  }
  return out;
}

void combine(int rows, int columns, const double *weights, const double *table, double *out) {
  if (columns >= 12) return combine_wide(rows, columns, weights, table, out);
  int j = 0; // few points: not worth the preparations
  for (; j + 4 <= columns; j += 4) {
    double a = 0, b = 0, c = 0, d = 0;
    const double *row = table + j;
    for (int i = 0; i < rows; ++i, row += columns) {
      const double w = weights[i];
      a += w * row[0], b += w * row[1], c += w * row[2], d += w * row[3];
    }
    out[j] = a, out[j + 1] = b, out[j + 2] = c, out[j + 3] = d;
  }
  for (; j < columns; ++j) {
    double sum = 0;
    for (int i = 0; i < rows; ++i) sum += weights[i] * table[i * columns + j];
    out[j] = sum;
  }
}

} // namespace dovetail
