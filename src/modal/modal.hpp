#pragma once
// The harmonic system without any large sparse matrix: K and M as the dense rows they are, and the Jacobian solved with
// in the modes of the stuck structure (modal_solver.hpp). The unknowns are the same as in the assembled form. On a
// sector each |h| that harmonics have has K, M and modes of its own, made when the first harmonic wants them.
#include "contact/law.hpp"
#include "modal/index_groups.hpp"
#include "modal/linear_part.hpp"
#include "modal/slab_products.hpp"
#include "stuck/stuck_basis.hpp"

namespace dovetail {

class Modal : public LinearPart {
public:
  /// `indices`: of a sector's model, for the wave; `reach`: see near_basis.hpp. K and M are taken out of `model`.
  /// Collective.
  Modal(ReducedModel &model, std::vector<SectorIndex> indices, const TravellingWave &wave,
        const std::vector<ContactPoint> &contact, const std::vector<Standstill> &standstill, const Damping &damping,
        const Layout &layout, double reach);

  std::unique_ptr<LinearPart> like(const Layout &layout) const override;
  void multiply(const double *q, double *stiffness_force, double *inertia_force) override;
  void multiply_and_share(const double *q, double *stiffness_force, double *inertia_force, std::vector<double> &sums,
                          MPI_Comm comm) override;
  std::vector<Coupling> couplings() const override;
  UniqueMat matrix(const ContactDerivative &contact) const override;
  void fill(Mat J, const JacobianParts &parts) override;
  void set_up(KSP ksp, Mat J) const override;
  std::string recover(KSP ksp, Mat J) const override;
  int determinant_sign(KSP ksp) const override;
  double take_work(Mat J) const override;
  double memory(Mat J) const override;
  void begin(Mat J, double memory, bool for_one) const override;
  std::vector<double> own_sums(Mat J, const ContactDerivative &contact) const override;
  void take_sums(Mat J, const double *sums) const override;
  LinearEffort take_effort(Mat J, int solves) const override;

private:
  struct Matrices { // of one |h|; of complex ones the real part of each column block, then the imaginary one
    std::vector<double> kaa;
    Slab<double> max;       // (own modes, 3 N_x)
    Slab<double> mass;      // (own contact dofs, N_a + 3 N_x): M_xa, M_xx
    Slab<double> stiffness; // (own contact dofs, 3 N_x): K_xx
  };
  static Matrices taken_from(ReducedModel &model, const Layout &layout);
  static Matrices matrices_of(const SectorIndex &index, const Layout &layout);
  struct Model { // for any harmonics
    TravellingWave wave;
    ReducedModel whole;               // without matrices
    std::vector<SectorIndex> indices; // (N / 2) of which no harmonic has had any yet
    std::vector<Matrices> matrices;   // by |h|
    StuckBases bases, open;           // with contacts stuck, and without any: the latter of models that are not large
    std::shared_ptr<Dampers> dampers; // or none
    void make(const std::vector<IndexGroup> &groups, const Layout &layout);
  };
  struct Sheaf { // the coefficients of harmonics that share matrices
    IndexGroup of;
    Bundle<double> all;      // (N_a + 3 N_x, columns); of complex matrices each of the two blocks twice
    Bundle<double> contact;  // its last block
    Aligned<double> product; // (own dofs, columns)
  };
  Modal(std::shared_ptr<Model> model, const Layout &layout);
  void gather(const double *q, std::vector<double> &sums);

  std::shared_ptr<Model> model_;
  Layout layout_;
  std::vector<Sheaf> sheaves_;
  std::vector<int> counts_, starts_; // of the ranks' coefficients
  std::vector<PetscInt> order_;      // numbers of the dofs, rank by rank
  std::vector<double> received_;     // (dofs * width) those of all ranks
};

} // namespace dovetail
