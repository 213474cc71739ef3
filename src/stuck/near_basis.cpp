#include "stuck/near_basis.hpp"

#include <petscsys.h>
// needs the one above
#include <petscblaslapack.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <new>

#include "stuck/low_modes.hpp"
#include "stuck/pencil_matrices.hpp"

extern "C" { // ScaLAPACK and LAPACK, without headers
void pdpotrf_(const char *, const int *, double *, const int *, const int *, const int *, int *);
void pdtrmm_(const char *, const char *, const char *, const char *, const int *, const int *, const double *,
             const double *, const int *, const int *, const int *, double *, const int *, const int *, const int *);
void pstrtri_(const char *, const char *, const int *, float *, const int *, const int *, const int *, int *);
void dlarft_(const char *, const char *, const int *, const int *, const double *, const int *, const double *,
             double *, const int *);
void sgemm_(const char *, const char *, const int *, const int *, const int *, const float *, const float *,
            const int *, const float *, const int *, const float *, float *, const int *);
}

namespace dovetail {
namespace {

constexpr int one = 1;
constexpr int first_guess = 60; // modes; with 30 to 200 GMRES took as many iterations, on 3090 dofs: measured
constexpr double beyond = 16;   // times the square of the highest frequency: a round of refinement gains a digit and a
                                // half, and four times as many harmonics still gain

// This rank's part of a triangular matrix; in single precision it takes half of the memory, and gives back the rest.
class Triangle {
public:
  explicit Triangle(const BlockCyclic &grid, const BlockCyclic::Row &row)
      : size_(grid.own_size()), values_(static_cast<double *>(std::calloc(size_, sizeof(double)))) {
    if (!values_) throw std::bad_alloc();
    grid.take(BlockCyclic::Part::whole, row, values_.get());
  }
  double *values() { return values_.get(); }
  float *rounded() {
    auto *const to = reinterpret_cast<char *>(values_.get());
    for (std::size_t i = 0; i < size_; ++i) { // the i-th lies where none before it is still to be read
      const float value = static_cast<float>(values_.get()[i]);
      std::memcpy(to + i * sizeof value, &value, sizeof value);
    }
    void *const kept = std::realloc(values_.get(), size_ * sizeof(float));
    if (kept) static_cast<void>(values_.release()), values_.reset(static_cast<double *>(kept));
    return reinterpret_cast<float *>(values_.get());
  }

private:
  struct Free {
    void operator()(double *values) const { std::free(values); }
  };
  std::size_t size_;
  std::unique_ptr<double[], Free> values_;
};

// Q = I - V T V^T with the columns of U first, but for their signs: V (n, modes), T (modes, modes).
struct Reflections {
  std::vector<float> V, T;
};

Reflections reflections_of(std::vector<double> U, PetscBLASInt n, PetscBLASInt modes) {
  PetscBLASInt info, room = 64 * modes;
  std::vector<double> tau(modes), work(room), T(static_cast<std::size_t>(modes) * modes);
  LAPACKgeqrf_(&n, &modes, U.data(), &n, tau.data(), work.data(), &room, &info);
  for (PetscBLASInt j = 0; j < modes; ++j) {
    std::fill_n(&U[static_cast<std::size_t>(j) * n], j, 0.0);
    U[static_cast<std::size_t>(j) * n + j] = 1;
  }
  dlarft_("F", "C", &n, &modes, U.data(), &n, tau.data(), T.data(), &modes);
  return {{U.begin(), U.end()}, {T.begin(), T.end()}};
}

// Rows of R^-1 become rows of R^-1 Q.
void reflect(const Reflections &by, int n, int modes, Slab<float> &rows) {
  constexpr int at_once = 512;
  const float plus = 1, minus = -1, none = 0;
  const int stride = static_cast<int>(rows.stride());
  std::vector<float> among(static_cast<std::size_t>(modes) * at_once), turned(among.size());
  for (std::size_t first = 0; first < rows.rows(); first += at_once) {
    const int count = static_cast<int>(std::min<std::size_t>(at_once, rows.rows() - first));
    float *const part = rows.row(first);
    sgemm_("T", "N", &modes, &count, &n, &plus, by.V.data(), &n, part, &stride, &none, among.data(), &modes);
    sgemm_("T", "N", &modes, &count, &modes, &plus, by.T.data(), &modes, among.data(), &modes, &none, turned.data(),
           &modes);
    sgemm_("N", "N", &n, &count, &modes, &minus, by.V.data(), &n, turned.data(), &modes, &plus, part, &stride);
  }
}

} // namespace

std::optional<StuckBasis> near_basis(const PencilRows &rows, const std::vector<double> &springs, const Layout &layout,
                                     double reach) {
  const int n = static_cast<int>(layout.dofs());
  const std::size_t own = layout.own_dofs();
  int count = std::min(first_guess, n / 4);
  if (count == 0) return {};
  auto low = low_modes_by_lanczos(rows, springs, layout, count + 1);
  while (low && low->squares[count] < beyond * reach * reach && 2 * count <= n / 2)
    count *= 2, low = low_modes_by_lanczos(rows, springs, layout, count + 1);
  if (!low) throw InputError(mass_not_positive(rows.file));
  if (!(low->squares.front() > 0)) return {};
  PencilMatrices pencil(rows, springs, 0, layout);
  const BlockCyclic &grid = pencil.grid();
  Triangle R(grid, [&](std::size_t d) { return pencil.row(d); });
  int info = 0;
  pdpotrf_("U", &n, R.values(), &one, &one, grid.descriptor(), &info);
  MPI_Allreduce(MPI_IN_PLACE, &info, 1, MPI_INT, MPI_MAX, layout.comm);
  if (info != 0) return {};

  std::vector<double> shapes(low->shapes.begin(), low->shapes.begin() + count * own);
  for (int j = 0; j < count; ++j)
    for (std::size_t d = 0; d < own; ++d) shapes[j * own + d] /= std::sqrt(low->squares[j]);
  std::vector<double> U = by_number(layout, shapes.data(), own, count), local = grid.take_columns(U.data(), count);
  const double once = 1;
  const auto of_columns = grid.columns_descriptor(count);
  pdtrmm_("L", "U", "N", "N", &n, &count, &once, R.values(), &one, &one, grid.descriptor(), local.data(), &one, &one,
          of_columns.data());
  grid.give_columns(local, count, U.data());
  const Reflections reflections = reflections_of(std::move(U), n, count);

  StuckBasis basis;
  basis.springs = springs, basis.near = true;
  {
    float *const inverse = R.rounded();
    basis.phi = Slab<float>(own, n); // not before, for its memory
    pstrtri_("U", "N", &n, inverse, &one, &one, grid.descriptor(), &info);
    MPI_Allreduce(MPI_IN_PLACE, &info, 1, MPI_INT, MPI_MAX, layout.comm);
    if (info != 0) return {}; // too small for single precision
    grid.give<float>(inverse, [&](std::size_t d, int first, int many, const float *values) {
      const int number = static_cast<int>(layout.number(static_cast<PetscInt>(d)));
      for (int j = std::max(first, number); j < first + many; ++j) basis.phi.row(d)[j] = values[j - first];
    });
  }
  reflect(reflections, n, count, basis.phi);
  const double rest = 2 * low->squares[count];
  basis.lambda.assign(n, rest);
  std::copy_n(low->squares.begin(), count, basis.lambda.begin());
  for (std::size_t d = 0; d < own; ++d) {
    float *const row = basis.phi.row(d);
    for (int j = 0; j < count; ++j) row[j] = static_cast<float>(low->shapes[j * own + d]);
    for (int j = count; j < n; ++j) row[j] *= static_cast<float>(std::sqrt(rest));
  }
  return basis;
}

} // namespace dovetail
