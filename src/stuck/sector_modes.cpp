#include "stuck/sector_modes.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "support/error.hpp"

namespace dovetail {
namespace {

using Complex = std::complex<double>;

// Index 0 in the same form as the others.
SectorIndex as_index(const ReducedModel &model) {
  SectorIndex index;
  index.kaa = model.kaa;
  index.mxa.assign(model.mxa.begin(), model.mxa.end());
  index.mxx.assign(model.mxx.begin(), model.mxx.end());
  index.kxx.assign(model.kxx.begin(), model.kxx.end());
  return index;
}

} // namespace

HermitianPencil pencil(const ReducedModel &model, int h, const std::vector<double> &springs, int root) {
  return h == 0 ? pencil(model, as_index(model), springs, root) : pencil(model, model.indices[h - 1], springs, root);
}

SectorModes sector_modes(const HermitianPencil &of, int count, const std::filesystem::path &file) {
  const int n = of.K.rows;
  double shift = INFINITY; // below the first square as a rule, so that K + shift M is positive without harm
  for (int i = 0; i < n; ++i)
    if (const double k = of.K(i, i).real(), m = of.M(i, i).real(); k > 0 && m > 0) shift = std::min(shift, k / m);
  if (!std::isfinite(shift)) shift = 1;
  ComplexDense K = of.K;
  for (std::size_t i = 0; i < K.values.size(); ++i) K.values[i] += shift * of.M.values[i];
  HermitianModes modes = lowest_modes(std::move(K), of.M, count);
  if (modes.fault != HermitianModes::Fault::none) throw InputError(mass_not_positive(file));
  std::vector<double> diagonal;
  for (int i = 0; i < n; ++i) diagonal.push_back(of.K(i, i).real());
  SectorModes found{{}, std::move(modes.shapes)};
  for (int j = 0; j < count; ++j) {
    const double square = modes.squares[j] - shift;
    Complex *v = found.shapes.column(j);
    found.squares.push_back(is_rigid(square, v, diagonal) ? 0 : square);
    const Complex turn = phase_of(v, v + n);
    std::for_each(v, v + n, [turn](Complex &value) { value *= turn; });
  }
  return found;
}

SectorModes sector_modes(const ReducedModel &model, int h, const std::vector<double> &springs, int count) {
  const HermitianPencil of = pencil(model, std::abs(h), springs, 0);
  const int n = static_cast<int>(model.modes + model.contact_dofs());
  int rank;
  MPI_Comm_rank(model.comm, &rank);
  SectorModes found;
  on_all_ranks(model.comm, [&] {
    if (rank == 0) found = sector_modes(of, count, model.file);
  });
  if (rank > 0) found = {std::vector<double>(count), ComplexDense(n, count)};
  MPI_Bcast(found.squares.data(), count, MPI_DOUBLE, 0, model.comm);
  MPI_Bcast(found.shapes.values.data(), n * count, MPI_C_DOUBLE_COMPLEX, 0, model.comm);
  if (h < 0)
    for (Complex &value : found.shapes.values) value = std::conj(value);
  return found;
}

} // namespace dovetail
