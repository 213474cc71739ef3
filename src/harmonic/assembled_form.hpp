#pragma once
// The harmonic system as one sparse matrix, (N_a + 3 N_x)(2H+1) + 1 unknowns, factored by MUMPS: the plain way, which
// the modal form is measured against. What it is made of besides K and M, whatever their form.
#include "modal/dampers.hpp"

namespace dovetail {

/// Where the entries of a matrix are, in the order in which their values are given.
struct EntryPlaces {
  std::vector<PetscInt> rows, columns;
  void add(PetscInt i, PetscInt j) { rows.push_back(i), columns.push_back(j); }
};

/// Square, spread as the rows of the system are: `rows` unknowns for each dof. Values given once. Collective.
UniqueMat spread_matrix(const Layout &layout, int rows, EntryPlaces places, const std::vector<double> &values);

class AssembledForm : public LinearPart {
public:
  /// `damps_mass`: see DynamicStiffness. Collective.
  AssembledForm(const Layout &layout, bool damps_mass);

  void take(std::shared_ptr<const Dampers> dampers); ///< Collective.
  void damp_mass() override { damps_mass_ = true; }
  UniqueMat matrix(const ContactDerivative &contact) const override;
  void fill(Mat J, const JacobianParts &parts) override;
  void set_up(KSP ksp, Mat J) const override;
  std::string recover(KSP ksp, Mat J) const override;
  int determinant_sign(KSP ksp) const override;
  LinearEffort take_effort(Mat, int solves) const override { return {solves, 0}; }

protected:
  /// Entries of D_k for all harmonics, and what they are, in the same order.
  virtual void place_structure(EntryPlaces &places) const = 0;
  virtual void write_structure(const DynamicStiffness &structure, std::vector<double> &values) const = 0;
  void share_dampers(AssembledForm &other) const;
  /// K q and M q by matrices that act on all own coefficients.
  void multiply_by(Mat K, Mat M, const double *q, double *stiffness_force, double *inertia_force);

  Layout layout_;
  bool damps_mass_; // the pattern of Q is that of M

private:
  std::vector<Dampers::Entry> damper_entries_;
  UniqueVec motion_, stiffness_force_, inertia_force_; // (dofs * width), without storage of their own
  std::vector<double> values_; // Jacobian entries in the order given to the matrix: structure, contact, border
};

} // namespace dovetail
