#include "harmonic/assembled.hpp"

#include "support/error.hpp"
#include "support/mumps.hpp"

namespace dovetail {
namespace {

UniqueMat square(const Layout &layout) {
  UniqueMat A;
  const PetscInt own = layout.own_dofs(), all = layout.dofs();
  check(MatCreate(layout.comm, A.out()), "building the harmonic system");
  check(MatSetSizes(A, own, own, all, all), "building the harmonic system");
  check(MatSetType(A, MATAIJ), "building the harmonic system");
  return A;
}

void fill_once(Mat A, std::vector<PetscInt> rows, std::vector<PetscInt> columns, const std::vector<double> &values) {
  check(MatSetPreallocationCOO(A, rows.size(), rows.data(), columns.data()), "building the harmonic system");
  check(MatSetValuesCOO(A, values.data(), INSERT_VALUES), "building the harmonic system");
}

} // namespace

Assembled::Assembled(std::vector<Coupling> couplings, const Layout &layout, bool damps_mass)
    : layout_(layout), damps_mass_(damps_mass), couplings_(std::move(couplings)) {
  std::vector<PetscInt> k_rows, k_columns, rows, columns;
  std::vector<double> k_values, values;
  for (const Coupling &c : couplings_) {
    rows.push_back(c.row), columns.push_back(c.column), values.push_back(c.m);
    if (c.stiff) k_rows.push_back(c.row), k_columns.push_back(c.column), k_values.push_back(c.k);
  }
  stiffness_ = square(layout_), mass_ = square(layout_);
  fill_once(stiffness_, std::move(k_rows), std::move(k_columns), k_values);
  fill_once(mass_, std::move(rows), std::move(columns), values);
  check(MatCreateMAIJ(stiffness_, layout_.width, stiffness_kron_.out()), "building the harmonic system");
  check(MatCreateMAIJ(mass_, layout_.width, mass_kron_.out()), "building the harmonic system");
  for (UniqueVec *v : {&motion_, &stiffness_force_, &inertia_force_})
    check(VecCreateMPIWithArray(layout_.comm, 1, layout_.own_coefficients(), PETSC_DETERMINE, nullptr, v->out()),
          "building the harmonic system");
}

std::unique_ptr<LinearPart> Assembled::like(const Layout &layout) const {
  auto other = std::make_unique<Assembled>(couplings_, layout, damps_mass_);
  other->dampers_ = dampers_, other->damper_entries_ = damper_entries_;
  return other;
}

void Assembled::take(std::shared_ptr<const Dampers> dampers) {
  damper_entries_ = dampers->entries();
  dampers_ = std::move(dampers);
}

void Assembled::multiply(const double *q, double *stiffness_force, double *inertia_force) {
  check(VecPlaceArray(motion_, q), "multiplying");
  check(VecPlaceArray(stiffness_force_, stiffness_force), "multiplying");
  check(VecPlaceArray(inertia_force_, inertia_force), "multiplying");
  check(MatMult(stiffness_kron_, motion_, stiffness_force_), "multiplying");
  check(MatMult(mass_kron_, motion_, inertia_force_), "multiplying");
  for (const Vec v : {Vec(motion_), Vec(stiffness_force_), Vec(inertia_force_)}) check(VecResetArray(v), "multiplying");
}

UniqueMat Assembled::matrix(const ContactForces &contact) const {
  std::vector<PetscInt> rows, columns;
  const int n = layout_.width, harmonics = n / 2;
  const auto add = [&](PetscInt i, PetscInt j) { rows.push_back(i), columns.push_back(j); };
  for (const Coupling &c : couplings_) { // the order of fill() below
    const PetscInt i = c.row * n, j = c.column * n;
    if (c.stiff) add(i, j);
    for (int k = 1; k <= harmonics; ++k) {
      add(i + cosine(k), j + cosine(k)), add(i + sine(k), j + sine(k));
      if (c.stiff || damps_mass_) add(i + cosine(k), j + sine(k)), add(i + sine(k), j + cosine(k));
    }
  }
  for (const Dampers::Entry &c : damper_entries_)
    for (int k = 1; k <= harmonics; ++k)
      add(c.row * n + cosine(k), c.column * n + sine(k)), add(c.row * n + sine(k), c.column * n + cosine(k));
  for (PetscInt p = 0; p < layout_.own_points.size(); ++p) {
    const PetscInt first = layout_.first_dof() * n + layout_.own_point_offset(p);
    for (const BlockPlace block : block_places(contact.points()[p].law))
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) add(first + block.row * n + i, first + block.column * n + j);
  }
  const PetscInt first = layout_.first_dof() * n, omega = layout_.omega_row();
  for (PetscInt i = 0; i < layout_.own_coefficients(); ++i) add(first + i, omega), add(omega, first + i);
  if (layout_.owns_omega()) add(omega, omega);

  UniqueMat J;
  check(MatCreate(layout_.comm, J.out()), "laying out the Jacobian");
  check(MatSetSizes(J, layout_.own_unknowns(), layout_.own_unknowns(), layout_.unknowns(), layout_.unknowns()),
        "laying out the Jacobian");
  check(MatSetType(J, MATAIJ), "laying out the Jacobian");
  check(MatSetPreallocationCOO(J, rows.size(), rows.data(), columns.data()), "laying out the Jacobian");
  return J;
}

void Assembled::fill(Mat J, const JacobianParts &parts) {
  const int n = layout_.width, harmonics = n / 2;
  values_.clear();
  for (const Coupling &c : couplings_) {
    if (c.stiff) values_.push_back(c.k);
    for (int k = 1; k <= harmonics; ++k) {
      const double in_phase = parts.structure.in_phase(k, c.k, c.m),
                   quadrature = parts.structure.quadrature(k, c.k, c.m);
      values_.push_back(in_phase), values_.push_back(in_phase);
      if (c.stiff || damps_mass_) values_.push_back(quadrature), values_.push_back(-quadrature);
    }
  }
  for (const Dampers::Entry &c : damper_entries_)
    for (int k = 1; k <= harmonics; ++k) {
      const double quadrature = parts.structure.turn(k) * c.viscous + parts.structure.hysteresis(k) * c.hysteretic;
      values_.push_back(quadrature), values_.push_back(-quadrature);
    }
  for (PetscInt p = 0; p < layout_.own_points.size(); ++p) {
    const auto &places = block_places(parts.contact.points()[p].law);
    const std::size_t at = values_.size(), size = static_cast<std::size_t>(n) * n;
    values_.resize(at + places.size() * size);
    parts.contact.write(static_cast<int>(p), &values_[at]);
    for (std::size_t b = 0; parts.held && b < places.size(); ++b)
      if (places[b].row == places[b].column) values_[at + b * size] += parts.held[3 * p + places[b].row];
  }
  for (PetscInt i = 0; i < layout_.own_coefficients(); ++i)
    values_.push_back(parts.column[i]), values_.push_back(parts.border[i]);
  if (layout_.owns_omega()) values_.push_back(parts.border[layout_.own_coefficients()]);
  check(MatSetValuesCOO(J, values_.data(), INSERT_VALUES), "evaluating the Jacobian");
}

void Assembled::set_up(KSP ksp, Mat J) const { factor_by_lu(ksp, J); }

std::string Assembled::recover(KSP ksp, Mat J) const { return recover_lu(ksp, J); }

int Assembled::determinant_sign(KSP ksp) const { return dovetail::determinant_sign(ksp); }

} // namespace dovetail
