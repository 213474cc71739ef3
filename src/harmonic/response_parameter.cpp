#include "harmonic/response_parameter.hpp"

#include "harmonic/harmonic_system.hpp"

namespace dovetail {

void FrequencyParameter::derivative(const HarmonicSystem &system, const Setting &now,
                                    std::vector<double> &column) const {
  const std::vector<double> &u = system.stiffness_force(), &v = system.inertia_force();
  const double omega = now.omega, xi = system.scaled().damping;
  const int n = system.layout().width;
  for (PetscInt i = 0; i < system.layout().own_coefficients(); ++i) { // eq (13)
    const int place = static_cast<int>(i % n), k = (place + 1) / 2;
    const double cross = place == 0 ? 0 : place % 2 ? u[i + 1] : -u[i - 1];
    column[i] = -2 * k * k * omega * v[i] + k * xi * cross;
  }
}

void LoadParameter::derivative(const HarmonicSystem &system, const Setting &, std::vector<double> &column) const {
  const int n = system.layout().width;
  for (PetscInt i = 0; i < system.layout().own_coefficients(); ++i)
    column[i] = -force_coefficient(system.loads(), i / n, i % n);
}

} // namespace dovetail
