#include "stuck/pencil_matrices.hpp"

#include <petscblaslapack.h>

#include <algorithm>

#include "stuck/own_rows.hpp"
#include "support/gathered.hpp"
#include "support/shell.hpp"

namespace dovetail {
namespace {

constexpr const char *doing = "multiplying with the reduced structure";

// The numbers of a dense matrix that this rank has.
class Block {
public:
  explicit Block(Mat of) : of_(of) {
    check(MatDenseGetArray(of, &values_), doing);
    check(MatDenseGetLDA(of, &stride_), doing);
    check(MatGetSize(of, nullptr, &columns_), doing);
  }
  Block(const Block &) = delete;
  ~Block() { MatDenseRestoreArray(of_, &values_); }
  double *values() const { return values_; }
  std::size_t stride() const { return static_cast<std::size_t>(stride_); }
  int columns() const { return static_cast<int>(columns_); }

private:
  Mat of_;
  double *values_;
  PetscInt stride_, columns_;
};

PencilMatrices &owner_of_shell(Mat shell) {
  void *context;
  MatShellGetContext(shell, &context);
  return *static_cast<PencilMatrices *>(context);
}

// Products with several vectors at once, which read the matrix once.
void take_blocks(Mat shell) {
  const auto product = +[](Mat A, Mat X, Mat Y, void *) -> PetscErrorCode {
    PencilMatrices &owner = owner_of_shell(A);
    return owner.run([&] { owner.multiply_block(A, X, Y); });
  };
  for (const MatType type : {MATSEQDENSE, MATMPIDENSE})
    check(MatShellSetMatProductOperation(shell, MATPRODUCT_AB, nullptr, product, nullptr, type, type), doing);
}

} // namespace

BlockCyclic grid_of(const Layout &layout) {
  std::vector<std::vector<int>> rows;
  for (int r = 0; r < layout.size; ++r) {
    const std::vector<PetscInt> numbers = numbers_of(layout, r);
    rows.emplace_back(numbers.begin(), numbers.end());
  }
  return {layout.comm, static_cast<int>(layout.dofs()), std::move(rows)};
}

std::vector<double> by_number(const Layout &layout, const double *own, std::size_t stride, std::size_t columns) {
  const std::size_t rows = layout.own_dofs(), n = layout.dofs();
  std::vector<double> packed(rows * columns), all(n * columns);
  for (std::size_t c = 0; c < columns; ++c) std::copy_n(own + c * stride, rows, &packed[c * rows]);
  const std::vector<double> gotten = gathered(layout.comm, MPI_DOUBLE, packed);
  const double *from = gotten.data();
  for (int r = 0; r < layout.size; ++r) {
    const std::vector<PetscInt> numbers = numbers_of(layout, r);
    for (std::size_t c = 0; c < columns; ++c)
      for (const PetscInt number : numbers) all[c * n + number] = *from++;
  }
  return all;
}

PencilMatrices::PencilMatrices(const PencilRows &rows, const std::vector<double> &springs, double shift,
                               const Layout &layout)
    : rows_(rows), springs_(springs), shift_(shift), layout_(layout), grid_(grid_of(layout)), line_(layout.dofs()) {
  const PetscInt own = layout.own_dofs(), n = layout.dofs();
  stiffness_ = shell_matrix<&PencilMatrices::multiply_stiffness>(layout.comm, own, n, this, doing);
  mass_ = shell_matrix<&PencilMatrices::multiply_mass>(layout.comm, own, n, this, doing);
  take_blocks(stiffness_), take_blocks(mass_);
}

const double *PencilMatrices::row(std::size_t d) {
  const std::size_t own_modes = layout_.own_modes.size(), na = layout_.modes, nc = 3 * layout_.points;
  const PetscInt number = layout_.number(static_cast<PetscInt>(d));
  std::fill(line_.begin(), line_.end(), 0.0);
  if (d < own_modes) { // its coupling stands in the rows of the contact dofs
    line_[number] = rows_.kaa[number] + shift_;
    return line_.data();
  }
  const std::size_t i = d - own_modes;
  const double *k = rows_.kxx.row(i), *m = rows_.mxx.row(i), *coupling = rows_.mxa.row(i);
  for (std::size_t j = 0; j < na; ++j) line_[j] = shift_ * coupling[j];
  for (std::size_t j = 0; j < nc; ++j) line_[na + j] = k[j] + shift_ * m[j];
  line_[number] += springs_[i];
  return line_.data();
}

bool PencilMatrices::set_inverse(KSP ksp) {
  factors_.emplace(grid_);
  if (!factors_->factor([&](std::size_t d) { return row(d); })) return false;
  shell_solver<&PencilMatrices::solve>(ksp, stiffness_, this, doing);
  PC pc;
  check(KSPGetPC(ksp, &pc), doing);
  const auto block = +[](PC shell, Mat R, Mat X) -> PetscErrorCode {
    void *context;
    PCShellGetContext(shell, &context);
    auto &owner = *static_cast<PencilMatrices *>(context);
    return owner.run([&] { owner.solve_block(R, X); });
  };
  check(PCShellSetMatApply(pc, block), doing);
  return true;
}

void PencilMatrices::take_own(double *own, std::size_t stride, int columns) const {
  for (int c = 0; c < columns; ++c)
    for (PetscInt d = 0; d < layout_.own_dofs(); ++d)
      own[c * stride + d] = all_[static_cast<std::size_t>(c) * layout_.dofs() + layout_.number(d)];
}

// y = K_s x or M x, both of the own dofs.
void PencilMatrices::multiply(bool stiff, const double *x, std::size_t from, double *y, std::size_t to, int columns) {
  all_ = by_number(layout_, x, from, columns);
  const PetscBLASInt na = layout_.modes, nc = 3 * layout_.points, own = 3 * layout_.own_points.size(),
                     n = layout_.dofs(), many = columns, stride = static_cast<PetscBLASInt>(to), least = 1;
  const std::size_t own_modes = layout_.own_modes.size();
  const double one = 1, none = 0;
  const auto add = [&](const PencilRows::Rows &rows, PetscBLASInt length, const double *of, double before) {
    const PetscBLASInt lead = std::max(least, static_cast<PetscBLASInt>(rows.stride));
    if (own > 0)
      BLASgemm_("T", "N", &own, &many, &length, &one, rows.first, &lead, of, &n, &before, y + own_modes, &stride);
  };
  add(stiff ? rows_.kxx : rows_.mxx, nc, all_.data() + na, none);
  if (!stiff) add(rows_.mxa, na, all_.data(), one);
  std::vector<double> modal(static_cast<std::size_t>(na) * columns);
  if (!stiff && own > 0 && na > 0) { // M_ax of all contact dofs
    const PetscBLASInt lead = static_cast<PetscBLASInt>(rows_.mxa.stride), across = static_cast<PetscBLASInt>(from);
    BLASgemm_("N", "N", &na, &many, &own, &one, rows_.mxa.first, &lead, x + own_modes, &across, &none, modal.data(),
              &na);
  }
  if (!stiff)
    MPI_Allreduce(MPI_IN_PLACE, modal.data(), static_cast<int>(modal.size()), MPI_DOUBLE, MPI_SUM, layout_.comm);
  for (int c = 0; c < columns; ++c) {
    const double *in = x + c * from;
    double *out = y + c * to;
    for (std::size_t d = 0; d < own_modes; ++d) {
      const PetscInt number = layout_.number(static_cast<PetscInt>(d));
      out[d] = stiff ? rows_.kaa[number] * in[d] : in[d] + modal[static_cast<std::size_t>(c) * na + number];
    }
    for (PetscInt i = 0; i < own && stiff; ++i) out[own_modes + i] += springs_[i] * in[own_modes + i];
  }
}

void PencilMatrices::multiply_mass(Vec x, Vec y) {
  const std::size_t own = layout_.own_dofs();
  multiply(false, ReadValues(x), own, Values(y), own, 1);
}

void PencilMatrices::multiply_stiffness(Vec x, Vec y) {
  const std::size_t own = layout_.own_dofs();
  const ReadValues from(x);
  const Values to(y);
  std::vector<double> heavy(own);
  multiply(false, from, own, heavy.data(), own, 1);
  multiply(true, from, own, to, own, 1);
  for (std::size_t d = 0; d < own; ++d) to[d] += shift_ * heavy[d];
}

void PencilMatrices::multiply_block(Mat A, Mat X, Mat Y) {
  const Block x(X), y(Y);
  const std::size_t own = layout_.own_dofs();
  const bool stiff = A == static_cast<Mat>(stiffness_);
  multiply(stiff, x.values(), x.stride(), y.values(), y.stride(), x.columns());
  if (!stiff) return;
  std::vector<double> heavy(own * x.columns());
  multiply(false, x.values(), x.stride(), heavy.data(), own, x.columns());
  for (int c = 0; c < x.columns(); ++c)
    for (std::size_t d = 0; d < own; ++d) y.values()[c * y.stride() + d] += shift_ * heavy[c * own + d];
}

void PencilMatrices::solve(Vec r, Vec x) {
  all_ = by_number(layout_, ReadValues(r), layout_.own_dofs(), 1);
  factors_->solve(all_.data(), 1);
  take_own(Values(x), layout_.own_dofs(), 1);
}

void PencilMatrices::solve_block(Mat R, Mat X) {
  const Block from(R), to(X);
  all_ = by_number(layout_, from.values(), from.stride(), from.columns());
  factors_->solve(all_.data(), from.columns());
  take_own(to.values(), to.stride(), to.columns());
}

} // namespace dovetail
