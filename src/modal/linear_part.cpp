#include "modal/linear_part.hpp"

namespace dovetail {
namespace {

double mirrored(double value) { return value; }

std::complex<double> mirrored(std::complex<double> value) { return std::conj(value); }

} // namespace

void LinearPart::multiply_and_share(const double *q, double *stiffness_force, double *inertia_force,
                                    std::vector<double> &sums, MPI_Comm comm) {
  multiply(q, stiffness_force, inertia_force);
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), static_cast<int>(sums.size()), MPI_DOUBLE, MPI_SUM, comm);
}

template <class Number>
std::vector<CouplingOf<Number>> list_couplings(const Layout &layout, const std::vector<double> &kaa,
                                               const std::function<ContactRow<Number>(PetscInt)> &row) {
  std::vector<CouplingOf<Number>> couplings;
  for (PetscInt j = layout.own_modes.begin; j < layout.own_modes.end; ++j)
    couplings.push_back({layout.mode_row(j), layout.mode_row(j), kaa[j], 1, true});
  for (PetscInt i = 0; i < 3 * layout.own_points.size(); ++i) {
    const PetscInt at = layout.contact_row(3 * layout.own_points.begin + i);
    const ContactRow<Number> values = row(i);
    for (PetscInt j = 0; j < layout.modes; ++j) {
      couplings.push_back({at, layout.mode_row(j), 0, values.mxa[j], false});
      couplings.push_back({layout.mode_row(j), at, 0, mirrored(values.mxa[j]), false});
    }
    for (PetscInt j = 0; j < 3 * layout.points; ++j)
      couplings.push_back({at, layout.contact_row(j), values.kxx[j], values.mxx[j], true});
  }
  return couplings;
}

template std::vector<Coupling> list_couplings(const Layout &, const std::vector<double> &,
                                              const std::function<ContactRow<double>(PetscInt)> &);
template std::vector<ComplexCoupling> list_couplings(const Layout &, const std::vector<double> &,
                                                     const std::function<ContactRow<std::complex<double>>(PetscInt)> &);

} // namespace dovetail
