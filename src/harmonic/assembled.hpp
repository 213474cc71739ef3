#pragma once
// The assembled form where all harmonics have the same real K and M.
#include "harmonic/assembled_form.hpp"

namespace dovetail {

class Assembled : public AssembledForm {
public:
  /// `couplings`: this rank's. Collective.
  Assembled(std::vector<Coupling> couplings, const Layout &layout, bool damps_mass);

  std::unique_ptr<LinearPart> like(const Layout &layout) const override;
  void multiply(const double *q, double *stiffness_force, double *inertia_force) override;
  std::vector<Coupling> couplings() const override { return couplings_; }

protected:
  void place_structure(EntryPlaces &places) const override;
  void write_structure(const DynamicStiffness &structure, std::vector<double> &values) const override;

private:
  std::vector<Coupling> couplings_;
  UniqueMat stiffness_, mass_;           // (dofs, dofs) AIJ
  UniqueMat stiffness_kron_, mass_kron_; // the same acting on all 2H+1 coefficients at once
};

} // namespace dovetail
