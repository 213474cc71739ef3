#include "harmonic/assembled_form.hpp"

#include "support/error.hpp"
#include "support/mumps.hpp"

namespace dovetail {

UniqueMat spread_matrix(const Layout &layout, int rows, EntryPlaces places, const std::vector<double> &values) {
  UniqueMat A;
  const PetscInt own = layout.own_dofs() * rows, all = layout.dofs() * rows;
  check(MatCreate(layout.comm, A.out()), "building the harmonic system");
  check(MatSetSizes(A, own, own, all, all), "building the harmonic system");
  check(MatSetType(A, MATAIJ), "building the harmonic system");
  check(MatSetPreallocationCOO(A, places.rows.size(), places.rows.data(), places.columns.data()),
        "building the harmonic system");
  check(MatSetValuesCOO(A, values.data(), INSERT_VALUES), "building the harmonic system");
  return A;
}

AssembledForm::AssembledForm(const Layout &layout, bool damps_mass) : layout_(layout), damps_mass_(damps_mass) {
  for (UniqueVec *v : {&motion_, &stiffness_force_, &inertia_force_})
    check(VecCreateMPIWithArray(layout_.comm, 1, layout_.own_coefficients(), PETSC_DETERMINE, nullptr, v->out()),
          "building the harmonic system");
}

void AssembledForm::take(std::shared_ptr<const Dampers> dampers) {
  damper_entries_ = dampers->entries();
  dampers_ = std::move(dampers);
}

void AssembledForm::share_dampers(AssembledForm &other) const {
  other.dampers_ = dampers_, other.damper_entries_ = damper_entries_;
}

void AssembledForm::multiply_by(Mat K, Mat M, const double *q, double *stiffness_force, double *inertia_force) {
  check(VecPlaceArray(motion_, q), "multiplying");
  check(VecPlaceArray(stiffness_force_, stiffness_force), "multiplying");
  check(VecPlaceArray(inertia_force_, inertia_force), "multiplying");
  check(MatMult(K, motion_, stiffness_force_), "multiplying");
  check(MatMult(M, motion_, inertia_force_), "multiplying");
  for (const Vec v : {Vec(motion_), Vec(stiffness_force_), Vec(inertia_force_)}) check(VecResetArray(v), "multiplying");
}

UniqueMat AssembledForm::matrix(const ContactDerivative &contact) const {
  EntryPlaces places; // the order of fill() below
  const int n = layout_.width, harmonics = n / 2;
  place_structure(places);
  for (const Dampers::Entry &c : damper_entries_)
    for (int k = 1; k <= harmonics; ++k)
      places.add(c.row * n + cosine(k), c.column * n + sine(k)),
          places.add(c.row * n + sine(k), c.column * n + cosine(k));
  for (PetscInt p = 0; p < layout_.own_points.size(); ++p) {
    const PetscInt first = layout_.first_dof() * n + layout_.own_point_offset(p);
    for (const BlockPlace block : contact.places(static_cast<int>(p)))
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) places.add(first + block.row * n + i, first + block.column * n + j);
  }
  const PetscInt first = layout_.first_dof() * n, omega = layout_.omega_row();
  for (PetscInt i = 0; i < layout_.own_coefficients(); ++i) places.add(first + i, omega), places.add(omega, first + i);
  if (layout_.owns_omega()) places.add(omega, omega);

  UniqueMat J;
  check(MatCreate(layout_.comm, J.out()), "laying out the Jacobian");
  check(MatSetSizes(J, layout_.own_unknowns(), layout_.own_unknowns(), layout_.unknowns(), layout_.unknowns()),
        "laying out the Jacobian");
  check(MatSetType(J, MATAIJ), "laying out the Jacobian");
  check(MatSetPreallocationCOO(J, places.rows.size(), places.rows.data(), places.columns.data()),
        "laying out the Jacobian");
  return J;
}

void AssembledForm::fill(Mat J, const JacobianParts &parts) {
  const int n = layout_.width, harmonics = n / 2;
  values_.clear();
  write_structure(parts.structure, values_);
  for (const Dampers::Entry &c : damper_entries_)
    for (int k = 1; k <= harmonics; ++k) {
      const double quadrature = parts.structure.turn(k) * c.viscous + parts.structure.hysteresis(k) * c.hysteretic;
      values_.push_back(quadrature), values_.push_back(-quadrature);
    }
  for (PetscInt p = 0; p < layout_.own_points.size(); ++p) {
    const auto &places = parts.contact.places(static_cast<int>(p));
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

void AssembledForm::set_up(KSP ksp, Mat J) const { factor_by_lu(ksp, J); }

std::string AssembledForm::recover(KSP ksp, Mat J) const { return recover_lu(ksp, J); }

int AssembledForm::determinant_sign(KSP ksp) const { return dovetail::determinant_sign(ksp); }

} // namespace dovetail
