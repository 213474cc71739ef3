#include "harmonic/harmonic_system.hpp"

#include <algorithm>
#include <cmath>

#include "support/error.hpp"

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

void fill(Mat A, std::vector<PetscInt> rows, std::vector<PetscInt> columns, const std::vector<double> &values) {
  check(MatSetPreallocationCOO(A, rows.size(), rows.data(), columns.data()), "building the harmonic system");
  check(MatSetValuesCOO(A, values.data(), INSERT_VALUES), "building the harmonic system");
}

// Reduced matrices [K_aa 0; 0 K_xx], [I M_ax; M_xa M_xx] entry by entry. The owner of a contact row also gives its
// mirror image in the modal rows, wherever those live.
std::vector<Coupling> list_couplings(ReducedModel &model, const Layout &layout) {
  std::vector<Coupling> couplings;
  for (PetscInt j = layout.own_modes.begin; j < layout.own_modes.end; ++j)
    couplings.push_back({layout.mode_row(j), layout.mode_row(j), model.kaa[j], 1, true});
  for (PetscInt i = 0; i < model.own_contact_dofs(); ++i) {
    const PetscInt row = layout.contact_row(3 * layout.own_points.begin + i);
    for (PetscInt j = 0; j < model.modes; ++j) {
      const double m = model.mxa[i * model.modes + j];
      couplings.push_back({row, layout.mode_row(j), 0, m, false});
      couplings.push_back({layout.mode_row(j), row, 0, m, false});
    }
    for (PetscInt j = 0; j < model.contact_dofs(); ++j) {
      const std::size_t at = static_cast<std::size_t>(i) * model.contact_dofs() + j;
      couplings.push_back({row, layout.contact_row(j), model.kxx[at], model.mxx[at], true});
    }
  }
  for (auto *rows : {&model.kxx, &model.mxx, &model.mxa})
    std::vector<double>().swap(*rows); // the couplings hold it now
  return couplings;
}

ScaledModel with_softer_contacts(ScaledModel scaled, double stiffness) {
  for (ContactPoint &point : scaled.model.contact) point.kn *= stiffness;
  return scaled;
}

} // namespace

HarmonicSystem::HarmonicSystem(ScaledModel model, int harmonics, int samples, std::vector<double> fourier)
    : scaled_(std::move(model)), layout_(scaled_.model.reduced, harmonics), harmonics_(harmonics), samples_(samples),
      fourier_(std::move(fourier)), loose_(scaled_.model.reduced, layout_),
      forces_(scaled_.model.contact, scaled_.model.standstill, harmonics, samples),
      couplings_(list_couplings(scaled_.model.reduced, layout_)) {
  build();
}

HarmonicSystem::HarmonicSystem(const HarmonicSystem &like, int harmonics, int samples, double stiffness)
    : scaled_(with_softer_contacts(like.scaled_, stiffness)), layout_(scaled_.model.reduced, harmonics),
      harmonics_(harmonics), samples_(samples), fourier_(like.fourier_),
      forces_(scaled_.model.contact, scaled_.model.standstill, harmonics, samples), couplings_(like.couplings_) {
  build();
}

void HarmonicSystem::build() {
  fourier_.resize(layout_.width, 0.0);
  std::vector<PetscInt> k_rows, k_columns, rows, columns;
  std::vector<double> k_values, values;
  for (const Coupling &c : couplings_) {
    rows.push_back(c.row), columns.push_back(c.column), values.push_back(c.m);
    if (c.stiff) k_rows.push_back(c.row), k_columns.push_back(c.column), k_values.push_back(c.k);
  }
  stiffness_ = square(layout_), mass_ = square(layout_);
  fill(stiffness_, std::move(k_rows), std::move(k_columns), k_values);
  fill(mass_, std::move(rows), std::move(columns), values);
  check(MatCreateMAIJ(stiffness_, layout_.width, stiffness_kron_.out()), "building the harmonic system");
  check(MatCreateMAIJ(mass_, layout_.width, mass_kron_.out()), "building the harmonic system");
  check(VecCreateMPI(layout_.comm, layout_.own_coefficients(), PETSC_DETERMINE, motion_.out()),
        "building the harmonic system");
  check(VecDuplicate(motion_, stiffness_force_.out()), "building the harmonic system");
  check(VecDuplicate(motion_, inertia_force_.out()), "building the harmonic system");
}

UniqueVec HarmonicSystem::unknowns() const {
  UniqueVec y;
  check(VecCreateMPI(layout_.comm, layout_.own_unknowns(), layout_.unknowns(), y.out()), "creating the unknowns");
  check(VecSet(y, 0), "creating the unknowns");
  return y;
}

UniqueMat HarmonicSystem::matrix() const {
  std::vector<PetscInt> rows, columns;
  const int n = layout_.width;
  const auto add = [&](PetscInt i, PetscInt j) { rows.push_back(i), columns.push_back(j); };
  for (const Coupling &c : couplings_) { // the order of jacobian() below
    const PetscInt i = c.row * n, j = c.column * n;
    if (c.stiff) add(i, j);
    for (int k = 1; k <= harmonics_; ++k) {
      add(i + cosine(k), j + cosine(k)), add(i + sine(k), j + sine(k));
      if (c.stiff) add(i + cosine(k), j + sine(k)), add(i + sine(k), j + cosine(k));
    }
  }
  for (PetscInt p = 0; p < layout_.own_points.size(); ++p) {
    const PetscInt first = layout_.first_dof() * n + layout_.own_point_offset(p);
    for (const BlockPlace block : block_places(forces_.points()[p].law))
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

double HarmonicSystem::omega(Vec y) const {
  const double *own;
  check(VecGetArrayRead(y, &own), "reading Omega");
  const double value = shared_omega(own);
  check(VecRestoreArrayRead(y, &own), "reading Omega");
  return value;
}

double HarmonicSystem::shared_omega(const double *own) const {
  double value = layout_.owns_omega() ? own[layout_.own_coefficients()] : 0;
  MPI_Bcast(&value, 1, MPI_DOUBLE, layout_.size - 1, layout_.comm);
  return value;
}

void HarmonicSystem::products(const double *q) {
  check(VecPlaceArray(motion_, q), "multiplying");
  check(MatMult(stiffness_kron_, motion_, stiffness_force_), "multiplying");
  check(MatMult(mass_kron_, motion_, inertia_force_), "multiplying");
  check(VecResetArray(motion_), "multiplying");
}

void HarmonicSystem::evaluate_contact(const double *q) {
  const double *contact = q + layout_.own_point_offset(0);
  const std::size_t count = layout_.own_points.size() * 3 * layout_.width;
  if (contact_.size() == count && std::equal(contact_.begin(), contact_.end(), contact)) return;
  force_.resize(count);
  forces_.evaluate(contact, force_.data());
  contact_.assign(contact, contact + count);
}

double HarmonicSystem::load(PetscInt dof) const {
  const ReducedModel &model = scaled_.model.reduced;
  const PetscInt contact = dof - layout_.own_modes.size();
  return contact < 0 ? model.fa[layout_.own_modes.begin + dof] : model.fx[contact];
}

void HarmonicSystem::residual(Vec y, Vec f) {
  const int n = layout_.width;
  const double *q, *u, *v;
  double *out;
  check(VecGetArrayRead(y, &q), "evaluating the residual");
  const double last = shared_omega(q), omega = fixed_omega_ > 0 ? fixed_omega_ : last,
               factor = fixed_omega_ > 0 ? last : 1;
  products(q);
  check(VecGetArrayRead(stiffness_force_, &u), "evaluating the residual");
  check(VecGetArrayRead(inertia_force_, &v), "evaluating the residual");
  check(VecGetArray(f, &out), "evaluating the residual");
  for (PetscInt d = 0; d < layout_.own_dofs(); ++d) {
    const PetscInt at = d * n;
    const double force = factor * load(d);
    out[at] = u[at] - force * fourier_[0];
    for (int k = 1; k <= harmonics_; ++k) {
      const PetscInt c = at + cosine(k), s = at + sine(k);
      const double inertia = k * omega * k * omega, damping = k * omega * scaled_.damping;
      out[c] = u[c] - inertia * v[c] + damping * u[s] - force * fourier_[cosine(k)];
      out[s] = u[s] - inertia * v[s] - damping * u[c] - force * fourier_[sine(k)];
    }
  }
  evaluate_contact(q);
  for (std::size_t i = 0; i < force_.size(); ++i) out[layout_.own_point_offset(0) + i] += force_[i];
  check(VecRestoreArray(f, &out), "evaluating the residual");
  check(VecRestoreArrayRead(inertia_force_, &v), "evaluating the residual");
  check(VecRestoreArrayRead(stiffness_force_, &u), "evaluating the residual");
  check(VecRestoreArrayRead(y, &q), "evaluating the residual");
}

void HarmonicSystem::jacobian(Vec y, Vec border, Mat J) {
  const int n = layout_.width;
  const double *q, *u, *v, *last;
  check(VecGetArrayRead(y, &q), "evaluating the Jacobian");
  const double omega = fixed_omega_ > 0 ? fixed_omega_ : shared_omega(q), xi = scaled_.damping;
  products(q);
  values_.clear();
  for (const Coupling &c : couplings_) {
    if (c.stiff) values_.push_back(c.k);
    for (int k = 1; k <= harmonics_; ++k) {
      const double dynamic = c.k - k * omega * k * omega * c.m, damping = k * omega * xi * c.k;
      values_.push_back(dynamic), values_.push_back(dynamic);
      if (c.stiff) values_.push_back(damping), values_.push_back(-damping);
    }
  }
  evaluate_contact(q);
  const std::size_t blocks = values_.size();
  for (PetscInt p = 0; p < layout_.own_points.size(); ++p) {
    const std::size_t at = values_.size();
    values_.resize(at + block_places(forces_.points()[p].law).size() * n * n);
    forces_.write(p, &values_[at]);
  }
  if (loose_.motions() > 0) hold_adrift(blocks);
  check(VecGetArrayRead(stiffness_force_, &u), "evaluating the Jacobian");
  check(VecGetArrayRead(inertia_force_, &v), "evaluating the Jacobian");
  check(VecGetArrayRead(border, &last), "evaluating the Jacobian");
  for (PetscInt i = 0; i < layout_.own_coefficients(); ++i) { // eq (13), and the border's row
    const int place = static_cast<int>(i % n), k = (place + 1) / 2;
    const double cross = place == 0 ? 0 : place % 2 ? u[i + 1] : -u[i - 1];
    values_.push_back(fixed_omega_ > 0 ? -load(i / n) * fourier_[place] : -2 * k * k * omega * v[i] + k * xi * cross);
    values_.push_back(last[i]);
  }
  if (layout_.owns_omega()) values_.push_back(last[layout_.own_coefficients()]);
  check(VecRestoreArrayRead(border, &last), "evaluating the Jacobian");
  check(VecRestoreArrayRead(inertia_force_, &v), "evaluating the Jacobian");
  check(VecRestoreArrayRead(stiffness_force_, &u), "evaluating the Jacobian");
  check(VecRestoreArrayRead(y, &q), "evaluating the Jacobian");
  check(MatSetValuesCOO(J, values_.data(), INSERT_VALUES), "evaluating the Jacobian");
}

// Part of each spring on the diagonal of the constant parts, where contact itself gives none.
void HarmonicSystem::hold_adrift(std::size_t block) {
  constexpr double part = 0.25; // separation of bodies tried by experiment: 1/4 comes back from several gaps' distance
  const PetscInt points = layout_.own_points.size();
  const std::size_t size = static_cast<std::size_t>(layout_.width) * layout_.width;
  std::vector<double> stiffness, springs;
  for (PetscInt p = 0; p < points; ++p) {
    const ContactPoint &point = forces_.points()[p];
    const auto mean = forces_.mean_stiffness(p);
    stiffness.insert(stiffness.end(), mean.begin(), mean.end());
    for (int d = 0; d < 3; ++d) springs.push_back(d == 2 ? point.kn : has_friction(point.law) ? point.kt[d] : 0);
  }
  adrift_ = loose_.adrift(stiffness, springs);
  if (!adrift_) return;
  for (PetscInt p = 0; p < points; ++p)
    for (const BlockPlace place : block_places(forces_.points()[p].law)) {
      const std::size_t dof = 3 * p + place.row;
      if (place.row == place.column && std::abs(stiffness[dof]) < 1e-6 * springs[dof])
        values_[block] += part * springs[dof];
      block += size;
    }
}

} // namespace dovetail
