#pragma once
// The part of a harmonic system that is linear, K and M, and with it the form in which the Jacobian is held and solved
// with: assembled and factored (assembled.hpp; of a sector sector_assembled.hpp), or in the modes of the stuck
// structure by Krylov's method (modal.hpp).
#include <complex>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "contact/contact_derivative.hpp"
#include "scaling/dynamic_stiffness.hpp"
#include "stuck/layout.hpp"
#include "support/handle.hpp"
#include "support/linear_effort.hpp"

namespace dovetail {

/// One entry of the scaled reduced matrices, by its row and column among the dofs of the harmonic system.
template <class Number> struct CouplingOf {
  PetscInt row, column;
  Number k, m;
  bool stiff; ///< the pattern of K; M is taken to be everywhere
};
using Coupling = CouplingOf<double>;
using ComplexCoupling = CouplingOf<std::complex<double>>; ///< of a Hermitian matrix

using SectorCouplings = std::vector<std::vector<ComplexCoupling>>; ///< (N/2 + 1) by |h|; empty where no harmonic has it

/// The rows of an own contact dof in M_xa, M_xx and K_xx.
template <class Number> struct ContactRow { const Number *mxa, *mxx, *kxx; };

/// [K_aa 0; 0 K_xx], [I M_ax; M_xa M_xx] entry by entry, from the own contact rows. The owner of a contact row also
/// gives its mirror image in the modal rows, wherever those live.
template <class Number>
std::vector<CouplingOf<Number>> list_couplings(const Layout &layout, const std::vector<double> &kaa,
                                               const std::function<ContactRow<Number>(PetscInt own_contact_dof)> &row);

/// What a Jacobian at some motion consists of, besides K and M. Arrays are of the own rows.
struct JacobianParts {
  DynamicStiffness structure; ///< scaled
  ContactDerivative contact;  ///< at that motion
  const double *held;         ///< (own contact dofs) added to the derivative of the mean forces, or none
  const double *column;       ///< (own coefficients) derivative by the last unknown
  const double *border;       ///< (own unknowns) last row
};

class Dampers;

/// Where couplings() are wanted of a sector.
constexpr const char *other_in_every_harmonic =
    "a cyclic sector has other matrices in every harmonic, and this wants the same in all";

class LinearPart {
public:
  virtual ~LinearPart() = default;
  /// The same K and M for other harmonics.
  virtual std::unique_ptr<LinearPart> like(const Layout &layout) const = 0;
  /// K q and M q, (own coefficients) each, harmonic by harmonic. Collective.
  virtual void multiply(const double *q, double *stiffness_force, double *inertia_force) = 0;
  /// Damping that is not proportional to K and M, or none.
  const Dampers *dampers() const { return dampers_.get(); }
  /// This rank's share of K and M. ComputeError of a sector.
  virtual std::vector<Coupling> couplings() const = 0;

  /// From here on Jacobians have room for M in Q, also where the damping of the case has not.
  virtual void damp_mass() {}
  /// Empty Jacobian, bordered by the last unknown's row and column; fill() fills it. Collective.
  virtual UniqueMat matrix(const ContactDerivative &contact) const = 0;
  virtual void fill(Mat J, const JacobianParts &parts) = 0;
  /// Makes `ksp` solve with J. Before SetFromOptions.
  virtual void set_up(KSP ksp, Mat J) const = 0;
  /// After a solve that failed: what went wrong, in words; `ksp` is fit for the next.
  virtual std::string recover(KSP ksp, Mat J) const = 0;
  /// Sign of the determinant of the matrix solved with last: +1 or -1; 0 where the solver does not tell.
  virtual int determinant_sign(KSP ksp) const = 0;
  /// What the solver has learned from earlier Jacobians, as a number, and a beginning with nothing but that: what
  /// follows then depends on no earlier solve, and a run that is restarted does the same. `for_one`: a single Jacobian
  /// follows, of which factors serve no other.
  virtual double memory(Mat) const { return 0; }
  virtual void begin(Mat, double /*memory*/, bool /*for_one*/) const {}
  /// Operations spent on solving with J since last asked, roughly, as ContactFactors::work; infinite where
  /// they are not counted.
  virtual double take_work(Mat) const { return std::numeric_limits<double>::infinity(); }
  /// What was done with J since last asked; `solves` iterations, where every solve is one.
  virtual LinearEffort take_effort(Mat J, int solves) const = 0;

  /// multiply(), and `sums` become those over all ranks: by the same message, if the form has one. Collective.
  virtual void multiply_and_share(const double *q, double *stiffness_force, double *inertia_force,
                                  std::vector<double> &sums, MPI_Comm comm);
  /// This rank's part of sums that filling J with the contact as it stands will want to know; and the sums.
  virtual std::vector<double> own_sums(Mat, const ContactDerivative &) const { return {}; }
  virtual void take_sums(Mat, const double *) const {}

protected:
  std::shared_ptr<const Dampers> dampers_;
};

} // namespace dovetail
