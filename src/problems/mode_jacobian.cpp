#include "problems/mode_jacobian.hpp"

#include "support/error.hpp"
#include "support/mumps.hpp"

namespace dovetail {
namespace {

constexpr const char *doing = "evaluating the Jacobian of a mode";
constexpr int border = ModeBorder::width;

} // namespace

ModeJacobian::ModeJacobian(NonlinearMode &mode, HarmonicSystem &system)
    : mode_(mode), system_(system), layout_(system.layout()), couplings_(system.couplings()) {
  if (const Dampers *dampers = system_.dampers()) damper_entries_ = dampers->entries();
  std::vector<PetscInt> rows, columns;
  const int n = layout_.width, harmonics = n / 2;
  const auto add = [&](PetscInt i, PetscInt j) { rows.push_back(i), columns.push_back(j); };
  for (const Coupling &c : couplings_) { // the order of assemble() below
    const PetscInt i = c.row * n, j = c.column * n;
    if (c.stiff) add(i, j);
    for (int k = 1; k <= harmonics; ++k) {
      add(i + cosine(k), j + cosine(k)), add(i + sine(k), j + sine(k));
      add(i + cosine(k), j + sine(k)), add(i + sine(k), j + cosine(k));
    }
  }
  for (const Dampers::Entry &c : damper_entries_)
    for (int k = 1; k <= harmonics; ++k)
      add(c.row * n + cosine(k), c.column * n + sine(k)), add(c.row * n + sine(k), c.column * n + cosine(k));
  const PetscInt first = layout_.first_dof() * n, last = layout_.dofs() * n;
  for (PetscInt p = 0; p < layout_.own_points.size(); ++p) {
    const PetscInt at = first + layout_.own_point_offset(p);
    for (const BlockPlace block : block_places(system_.contact()[p].law))
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) add(at + block.row * n + i, at + block.column * n + j);
  }
  for (PetscInt i = 0; i < layout_.own_coefficients(); ++i)
    for (int b = 0; b < border; ++b) add(first + i, last + b), add(last + b, first + i);
  for (int i = 0; i < border && layout_.owns_omega(); ++i)
    for (int j = 0; j < border; ++j) add(last + i, last + j);

  const PetscInt own = layout_.own_coefficients() + (layout_.owns_omega() ? border : 0), all = last + border;
  check(MatCreate(layout_.comm, matrix_.out()), doing);
  check(MatSetSizes(matrix_, own, own, all, all), doing);
  check(MatSetType(matrix_, MATAIJ), doing);
  check(MatSetPreallocationCOO(matrix_, rows.size(), rows.data(), columns.data()), doing);
}

void ModeJacobian::set_up(KSP ksp) { factor_by_lu(ksp, matrix_); }
int ModeJacobian::determinant_sign(KSP ksp) { return dovetail::determinant_sign(ksp); }
std::string ModeJacobian::recover(KSP ksp) { return recover_lu(ksp, matrix_); }

void ModeJacobian::assemble(Vec y, Vec plane) {
  mode_.evaluate(y);
  border_.take(mode_, plane);
  const int n = layout_.width, harmonics = n / 2;
  const double alpha = mode_.state().amplitude;
  const DynamicStiffness structure = mode_.structure();
  values_.clear();
  for (const Coupling &c : couplings_) {
    if (c.stiff) values_.push_back(c.k);
    for (int k = 1; k <= harmonics; ++k) {
      const double in_phase = structure.in_phase(k, c.k, c.m), quadrature = structure.quadrature(k, c.k, c.m);
      values_.insert(values_.end(), {in_phase, in_phase, quadrature, -quadrature});
    }
  }
  for (const Dampers::Entry &c : damper_entries_)
    for (int k = 1; k <= harmonics; ++k) {
      const double quadrature = structure.turn(k) * c.viscous + structure.hysteresis(k) * c.hysteretic;
      values_.insert(values_.end(), {quadrature, -quadrature});
    }
  const double *held = system_.holding();
  for (PetscInt p = 0; p < layout_.own_points.size(); ++p) {
    const auto &places = block_places(system_.contact()[p].law);
    const std::size_t at = values_.size(), size = static_cast<std::size_t>(n) * n;
    values_.resize(at + places.size() * size);
    system_.contact_forces().write(static_cast<int>(p), &values_[at]);
    for (std::size_t b = 0; b < places.size(); ++b) {
      double *block = &values_[at + b * size]; // harmonics are in units of the amplitude, means are not
      for (int i = 1; i < n; ++i) block[i] *= alpha, block[i * n] /= alpha;
      if (held && places[b].row == places[b].column) block[0] += held[3 * p + places[b].row];
    }
  }
  for (PetscInt i = 0; i < layout_.own_coefficients(); ++i)
    for (int b = 0; b < border; ++b) values_.push_back(border_.columns[b][i]), values_.push_back(border_.rows[b][i]);
  for (int i = 0; i < border && layout_.owns_omega(); ++i)
    for (int j = 0; j < border; ++j) values_.push_back(i == border - 1 ? border_.corner[j] : 0);
  check(MatSetValuesCOO(matrix_, values_.data(), INSERT_VALUES), doing);
}

} // namespace dovetail
