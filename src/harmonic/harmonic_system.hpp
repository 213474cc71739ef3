#pragma once
// Harmonic balance of the scaled reduced model: residual of eqs (11)-(12) and its exact derivative by [X; Omega].
#include <vector>

#include "harmonic/linear_part.hpp"
#include "harmonic/load_case.hpp"
#include "harmonic/loose_body.hpp"
#include "harmonic/response_parameter.hpp"
#include "scaling/scaled_model.hpp"

namespace dovetail {

enum class LinearForm { assembled, modal }; ///< see linear_part.hpp

class HarmonicSystem {
public:
  /// `samples`: per period of the contact laws, or `exactly`; `loads`: patterns of the model that work, with f(t).
  /// Collective.
  HarmonicSystem(ScaledModel model, int harmonics, int samples, const std::vector<LoadCourse> &loads,
                 LinearForm form = LinearForm::assembled);

  /// The same equations with other harmonics or samples, and k_n times `stiffness`. Collective.
  HarmonicSystem(const HarmonicSystem &like, int harmonics, int samples);
  /// The same equations with other harmonics or samples, in the modal form. Collective.
  static std::unique_ptr<HarmonicSystem> modal(const HarmonicSystem &like, int harmonics, int samples);

  /// From here on the last unknown is that, in place of Omega.
  void vary(std::unique_ptr<ResponseParameter> parameter) { parameter_ = std::move(parameter); }
  const ResponseParameter &parameter() const { return *parameter_; }

  const Layout &layout() const { return layout_; }
  const Scales &scales() const { return scaled_.scales; }
  int harmonics() const { return harmonics_; }
  int samples() const { return samples_; }
  const ScaledModel &scaled() const { return scaled_; }                           ///< without the matrices
  std::vector<Coupling> couplings() const { return linear_->couplings(); }        ///< the matrices; this rank's share
  const std::vector<LoadCase> &loads() const { return loads_; }                   ///< by own dof
  const std::vector<LoadCase> &left_out_loads() const { return left_out_loads_; } ///< by mode of LeftOut

  UniqueVec unknowns() const; ///< y = [X; parameter], zero
  double omega(Vec y) const;  ///< last unknown, on every rank. Collective.

  /// f = residual of eq (11); its last entry, the parameter's row, is left alone. Collective.
  void residual(Vec y, Vec f);
  /// Empty Jacobian, bordered by Omega's row and column; `ksp` made to solve with it, before SetFromOptions.
  UniqueMat matrix() const { return linear_->matrix(forces_); }
  void set_up(KSP ksp, Mat J) const { linear_->set_up(ksp, J); }
  std::string recover(KSP ksp, Mat J) const { return linear_->recover(ksp, J); } ///< see linear_part.hpp
  int determinant_sign(KSP ksp) const { return linear_->determinant_sign(ksp); } ///< see linear_part.hpp
  double take_solver_work(Mat J) const { return linear_->take_work(J); }         ///< see linear_part.hpp
  double solver_memory(Mat J) const { return linear_->memory(J); }               ///< see linear_part.hpp
  void begin_solves(Mat J, double memory, bool for_one = false) const { linear_->begin(J, memory, for_one); }
  LinearEffort take_effort(Mat J, int solves) const { return linear_->take_effort(J, solves); } ///< see linear_part.hpp
  /// J = [d residual / d y; border^T], border (unknowns,). Collective.
  void jacobian(Vec y, Vec border, Mat J);

  /// Rigid motions that only the joint holds. While contacts leave one of them adrift, jacobian() holds the points'
  /// means by a part of their springs: Newton then finds the way back to contact, or the mean it started from.
  const LooseBody &loose_body() const { return loose_; }
  bool adrift() const { return adrift_; } ///< so it was when the Jacobian was evaluated last

  /// K q and M q of the motion evaluated last, (own coefficients).
  const std::vector<double> &stiffness_force() const { return stiffness_force_; }
  const std::vector<double> &inertia_force() const { return inertia_force_; }
  const std::vector<double> &damping_force() const { return damping_force_; } ///< C q of the dampers, or none
  const Dampers *dampers() const { return linear_->dampers(); }               ///< damping besides K and M, or none
  DynamicStiffness structure(double omega) const { return DynamicStiffness(scaled_.damping, omega); } ///< its D_k

  /// What the own contact points did over the period at the motion evaluated last, in scaled units.
  const std::vector<Activity> &activity() const { return forces_.activity(); }

private:
  void evaluate_contact(const double *q); // unless done at this motion
  void products(const double *q);         // stiffness_force_ = K q, inertia_force_ = M q, likewise
  bool hold_adrift();
  void fit_courses(); // to the harmonics
  double shared_omega(const double *own) const;

  ScaledModel scaled_;
  Layout layout_;
  int harmonics_, samples_;
  LinearForm form_;
  std::vector<LoadCase> loads_, left_out_loads_;
  LooseBody loose_;
  bool adrift_ = false;
  std::unique_ptr<ResponseParameter> parameter_ = std::make_unique<FrequencyParameter>();
  ContactForces forces_;
  std::vector<double> contact_; // (own points, 3, 2H+1) motion that forces_ was last evaluated at
  std::unique_ptr<LinearPart> linear_;
  std::vector<double> motion_, stiffness_force_, inertia_force_; // (own coefficients) of the last products
  std::vector<double> damping_force_, hysteretic_force_;         // likewise, C q and S q of the dampers, or empty
  std::vector<double> column_, held_;                            // of the Jacobian, see JacobianParts
  std::vector<double> force_;                                    // (own points, 3, 2H+1)
};

} // namespace dovetail
