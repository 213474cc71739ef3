#include "reduction/sector_motion.hpp"

namespace dovetail {
namespace {

// [Re A, Im A]^T of some rows of A.
Dense parts_below(const ComplexDense &A, const std::vector<int> &rows) {
  Dense out(2 * A.columns, static_cast<int>(rows.size()));
  for (int j = 0; j < A.columns; ++j)
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const std::complex<double> value = A(rows[i], j);
      out(j, static_cast<int>(i)) = value.real(), out(A.columns + j, static_cast<int>(i)) = value.imag();
    }
  return out;
}

std::vector<int> all_rows(const ComplexDense &A) {
  std::vector<int> rows(A.rows);
  for (int i = 0; i < A.rows; ++i) rows[i] = i;
  return rows;
}

// Some columns of A (rows, n) row-major, each of them a row.
Dense chosen(const std::vector<double> &A, std::size_t n, const std::vector<int> &columns) {
  Dense out(static_cast<int>(columns.size()), n > 0 ? static_cast<int>(A.size() / n) : 0);
  for (int row = 0; row < out.columns; ++row)
    for (int i = 0; i < out.rows; ++i) out(i, row) = A[row * n + columns[i]];
  return out;
}

} // namespace

SectorMotion::SectorMotion(const SectorCoordinates &E, PetscInt modes, Recovery &before) {
  for (int i = 0; i < E.held(); ++i)
    if (const int x = E.contact_at(i); x >= 0)
      same_.push_back(i), contact_.push_back(x);
    else
      rest_.push_back(i);
  by_rest_ = chosen(before.psi, E.held(), rest_), by_same_ = chosen(before.psi, E.held(), same_);
  before.psi = {};
  by_modes_.rows = static_cast<int>(modes), by_modes_.columns = by_rest_.columns;
  by_modes_.values = std::move(before.phi);
}

SectorMotion::Rows SectorMotion::of(const ComplexDense &by_b, const ComplexDense *by_modes) const {
  const int n = by_b.columns, count = by_rest_.columns;
  Rows rows;
  if (count == 0 || n == 0) return rows;
  Dense sum(2 * n, count);
  if (!rest_.empty()) multiply(1, parts_below(by_b, rest_), by_rest_, 0, sum);
  if (by_modes && by_modes_.rows > 0) multiply(1, parts_below(*by_modes, all_rows(*by_modes)), by_modes_, 1, sum);
  rows.reserve(static_cast<std::size_t>(count) * n);
  for (int i = 0; i < count; ++i)
    for (int j = 0; j < n; ++j) rows.emplace_back(sum(j, i), sum(n + j, i));
  return rows;
}

SectorMotion::Rows SectorMotion::of_contacts(const ComplexDense &by_x) const {
  Rows rows = of(by_x);
  const std::size_t n = by_x.columns;
  for (int row = 0; row < by_same_.columns && n > 0; ++row)
    for (std::size_t i = 0; i < same_.size(); ++i) rows[row * n + contact_[i]] += by_same_(static_cast<int>(i), row);
  return rows;
}

} // namespace dovetail
