#pragma once
// Solves with the bordered Jacobian [J b; c^T d] in the modes of the stuck structure (docs/theory/stuck-modes.md), one
// way or the other: GMRES in single precision, with rounds of refinement in double where more is asked for
// (modal_krylov.hpp); or, where few contacts move or many iterations would be wanted, factors of the contacts' part, as
// the preconditioner of GMRES in double: those of contact_factors.hpp, which serve the following Jacobians of the same
// Newton solve as well, or where contacts are open for long those of window_factors.hpp.
#include <array>
#include <memory>
#include <optional>

#include "modal/contact_factors.hpp"
#include "modal/modal_krylov.hpp"
#include "modal/window_factors.hpp"

namespace dovetail {

class ModalSolver {
public:
  /// `open`: modes of the structure without contacts, or none.
  ModalSolver(std::shared_ptr<const StuckBases> bases, std::shared_ptr<const StuckBases> open, const Layout &layout);
  ModalSolver(const ModalSolver &) = delete; // PETSc knows where it is

  /// the forces of `parts.contact` and `linear` must outlive the solves.
  void fill(const JacobianParts &parts, LinearPart &linear);
  /// The bordered Jacobian itself, in the unknowns of the harmonic system and in double precision. Collective.
  void multiply(Vec x, Vec y);
  /// Makes `ksp` solve with it: well enough for Newton's method, or as accurately as its relative tolerance asks for.
  void set_up(KSP ksp, Mat J);
  /// Sign of its determinant, from factors or from what GMRES met; confirmed by factors where it is new. 0 if too many
  /// contacts move.
  int determinant_sign();
  double memory() const; ///< see linear_part.hpp; sign and size: of_all_, expected_
  void begin(double memory, bool for_one);
  /// Contact dofs that move at the Jacobian to come, on this rank; and on all, which spares asking them.
  double own_moving(const ContactDerivative &contact) {
    all_moving_.reset();
    return factors_.own_moving(contact);
  }
  void take_moving(double all) { all_moving_ = all; }
  double take_work() { return std::exchange(work_, 0); }
  LinearEffort take_effort() { return std::exchange(effort_, {}); }

  template <class Work> PetscErrorCode run(Work &&work) { return courier_.run(work); }

private:
  void solve(Vec r, Vec x);
  bool solve_some_way(Vec r, Vec x, double asked); // false: it leaves more than is asked
  void choose(Vec r);                              // one way or the other, for a new Jacobian
  bool take_windows(double worth);
  bool factor(bool precisely = false);
  bool factor_all();
  bool may_factor() const;
  double worth_asking() const;
  double work_in_modes() const; // of an iteration, as ContactFactors::work
  double work_to_solve() const; // of an iteration with factors, likewise
  void apply_factors(Vec r, Vec x);
  enum class Solved { never, roughly, surely };
  template <class Round, class Sign> bool refine(Vec r, Vec x, double asked, const Round &round, const Sign &sign);
  int factors_sign();
  bool solve_with_factors(Vec r, Vec x, double asked); // false: not within as many iterations as are worth it
  bool solve_in_modes(Vec r, Vec x, double asked);     // likewise
  std::array<double, 2> left_by(Vec x, Vec r);
  JacobianParts parts() const;

  std::shared_ptr<const StuckBases> bases_, open_;
  Layout layout_;
  ModalKrylov in_modes_;
  ContactFactors factors_;
  std::optional<WindowFactors> windows_;
  ModalFactors *chosen_ = &factors_;        // of these two
  bool by_factors_ = false, fresh_ = false; // these factors, of this Jacobian
  bool failed_again_ = false;               // since begin(), factors of an earlier Jacobian
  bool of_all_ = false;                     // points, as if all of them moved
  double expected_ = 10;                    // iterations in the modes with one Jacobian,
  int taken_ = 0;                           // and with this one
  bool for_one_ = false;                    // Jacobian
  bool stale_ = true;                       // not chosen yet
  std::optional<double> all_moving_;        // at this Jacobian, where that was told
  std::optional<ContactDerivative> contact_;
  LinearPart *linear_ = nullptr;
  DynamicStiffness structure_;
  std::vector<double> held_, column_, border_; // (own contact dofs), (own coefficients), (own unknowns)
  std::vector<double> stiff_, heavy_, force_;  // (own coefficients)
  std::vector<double> damped_, lossy_;         // likewise, by dampers
  UniqueMat matrix_;
  UniqueKSP ksp_; // with factors
  UniqueVec remainder_, correction_;
  PetscInt most_factored_ = 4000; // unknowns of contacts that move, unless an option says otherwise
  KSP outer_ = nullptr;
  int sign_ = 0;                  // of the determinant, the last time
  std::optional<int> first_sign_; // by the first round of the last solve, where others followed
  LinearEffort effort_;
  double work_ = 0;
  double forces_square_ = 0; // of the last product: square of the forces that cancel in it, on this rank
  Courier courier_;
};

} // namespace dovetail
