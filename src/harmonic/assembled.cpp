#include "harmonic/assembled.hpp"

#include "support/error.hpp"

namespace dovetail {

Assembled::Assembled(std::vector<Coupling> couplings, const Layout &layout, bool damps_mass)
    : AssembledForm(layout, damps_mass), couplings_(std::move(couplings)) {
  EntryPlaces stiff, heavy;
  std::vector<double> k_values, values;
  for (const Coupling &c : couplings_) {
    heavy.add(c.row, c.column), values.push_back(c.m);
    if (c.stiff) stiff.add(c.row, c.column), k_values.push_back(c.k);
  }
  stiffness_ = spread_matrix(layout_, 1, std::move(stiff), k_values);
  mass_ = spread_matrix(layout_, 1, std::move(heavy), values);
  check(MatCreateMAIJ(stiffness_, layout_.width, stiffness_kron_.out()), "building the harmonic system");
  check(MatCreateMAIJ(mass_, layout_.width, mass_kron_.out()), "building the harmonic system");
}

std::unique_ptr<LinearPart> Assembled::like(const Layout &layout) const {
  auto other = std::make_unique<Assembled>(couplings_, layout, damps_mass_);
  share_dampers(*other);
  return other;
}

void Assembled::multiply(const double *q, double *stiffness_force, double *inertia_force) {
  multiply_by(stiffness_kron_, mass_kron_, q, stiffness_force, inertia_force);
}

void Assembled::place_structure(EntryPlaces &places) const {
  const int n = layout_.width, harmonics = n / 2;
  for (const Coupling &c : couplings_) {
    const PetscInt i = c.row * n, j = c.column * n;
    if (c.stiff) places.add(i, j);
    for (int k = 1; k <= harmonics; ++k) {
      places.add(i + cosine(k), j + cosine(k)), places.add(i + sine(k), j + sine(k));
      if (c.stiff || damps_mass_) places.add(i + cosine(k), j + sine(k)), places.add(i + sine(k), j + cosine(k));
    }
  }
}

void Assembled::write_structure(const DynamicStiffness &structure, std::vector<double> &values) const {
  const int harmonics = layout_.width / 2;
  for (const Coupling &c : couplings_) {
    if (c.stiff) values.push_back(c.k);
    for (int k = 1; k <= harmonics; ++k) {
      const double in_phase = structure.in_phase(k, c.k, c.m), quadrature = structure.quadrature(k, c.k, c.m);
      values.push_back(in_phase), values.push_back(in_phase);
      if (c.stiff || damps_mass_) values.push_back(quadrature), values.push_back(-quadrature);
    }
  }
}

} // namespace dovetail
