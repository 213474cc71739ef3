#include "harmonic/response_parameter.hpp"

#include "harmonic/harmonic_system.hpp"

namespace dovetail {
namespace {

// Coefficient i, at that place of its row, of a motion times the imaginary unit.
double across(const std::vector<double> &of, PetscInt i, int place) {
  return place == 0 ? 0 : place % 2 ? of[i + 1] : -of[i - 1];
}

} // namespace

void FrequencyParameter::derivative(const HarmonicSystem &system, const Setting &now,
                                    std::vector<double> &column) const {
  const std::vector<double> &u = system.stiffness_force(), &v = system.inertia_force(), &w = system.damping_force();
  const DynamicStiffness structure = system.structure(now.omega);
  const int n = system.layout().width;
  for (PetscInt i = 0; i < system.layout().own_coefficients(); ++i) { // eq (13)
    const int place = static_cast<int>(i % n), k = (place + 1) / 2;
    column[i] = -structure.inertia_slope(k) * v[i] + structure.loss_slope(k) * across(u, i, place) +
                structure.drag_slope(k) * across(v, i, place);
    if (!w.empty()) column[i] += k * across(w, i, place);
  }
}

void LoadParameter::derivative(const HarmonicSystem &system, const Setting &, std::vector<double> &column) const {
  const int n = system.layout().width;
  for (PetscInt i = 0; i < system.layout().own_coefficients(); ++i)
    column[i] = -force_coefficient(system.loads(), i / n, i % n);
}

} // namespace dovetail
