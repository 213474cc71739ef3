#pragma once
// Harmonic balance of the scaled reduced model: residual of eqs (11)-(12) and its exact derivative by [X; Omega].
#include <memory>
#include <optional>
#include <vector>

#include "harmonic/load_case.hpp"
#include "harmonic/loose_body.hpp"
#include "harmonic/response_parameter.hpp"
#include "modal/linear_part.hpp"
#include "preload/varied_preload.hpp"
#include "scaling/scaled_model.hpp"

namespace dovetail {

enum class LinearForm { assembled, modal }; ///< see linear_part.hpp

class HarmonicSystem {
public:
  /// `samples`: per period of the contact laws, or `exactly`; `loads`: patterns of the model that work, with f(t).
  /// Collective.
  HarmonicSystem(ScaledModel model, int harmonics, int samples, const std::vector<LoadCourse> &loads,
                 LinearForm form = LinearForm::assembled);

  /// The same equations with other harmonics or samples. Collective.
  HarmonicSystem(const HarmonicSystem &like, int harmonics, int samples);
  /// The same equations with other harmonics or samples, in the modal form; cyclic ones in the form they have.
  /// Collective.
  static std::unique_ptr<HarmonicSystem> modal(const HarmonicSystem &like, int harmonics, int samples);

  /// From here on the last unknown is that, in place of Omega. `preload`: of this model, where it changes the joint.
  void vary(ResponseParameter parameter, std::shared_ptr<VariedPreload> preload = nullptr);
  const ResponseParameter &parameter() const { return parameter_; }
  const std::shared_ptr<VariedPreload> &preload() const { return preload_; } ///< given with that, or none
  /// The equations are those at that value of it; false where the joint has no state of preload. Collective.
  bool set(double value);
  const Setting &setting() const { return setting_; }                                ///< at the value set last
  const std::vector<ContactPoint> &contact() const { return forces_.points(); }      ///< own points, there
  const std::vector<Standstill> &standstill() const { return forces_.standstill(); } ///< likewise
  /// (3 own) constant force on the contact dofs, there; empty where the joint does not change.
  const std::vector<double> &constant() const { return constant_; }

  LinearForm form() const { return form_; }
  const Layout &layout() const { return layout_; }
  const Scales &scales() const { return scaled_.scales; }
  TravellingWave wave() const { return {scaled_.model.reduced.sectors, scaled_.engine_order}; }
  bool is_cyclic() const { return wave().sectors > 0; } ///< one sector of several, and every harmonic with its own K, M
  int harmonics() const { return harmonics_; }
  int samples() const { return samples_; }
  const ScaledModel &scaled() const { return scaled_; }                           ///< without the matrices
  std::vector<Coupling> couplings() const { return linear_->couplings(); }        ///< the matrices; this rank's share
  const std::vector<LoadCase> &loads() const { return loads_; }                   ///< by own dof
  const std::vector<LoadCase> &left_out_loads() const { return left_out_loads_; } ///< by mode of LeftOut

  UniqueVec unknowns() const;       ///< y = [X; parameter], zero
  double parameter_in(Vec y) const; ///< last unknown, on every rank. Collective.

  /// f = residual of eq (11); its last entry, the parameter's row, is left alone. Returns border . y if there is a
  /// border. Collective.
  double residual(Vec y, Vec f, Vec border = nullptr);
  void damp_mass() { linear_->damp_mass(); } ///< see linear_part.hpp
  /// Empty Jacobian, bordered by Omega's row and column; `ksp` made to solve with it, before SetFromOptions.
  UniqueMat matrix(bool transposed = false) const { return linear_->matrix(ContactDerivative(forces_, transposed)); }
  void set_up(KSP ksp, Mat J) const { linear_->set_up(ksp, J); }
  std::string recover(KSP ksp, Mat J) const { return linear_->recover(ksp, J); } ///< see linear_part.hpp
  int determinant_sign(KSP ksp) const { return linear_->determinant_sign(ksp); } ///< see linear_part.hpp
  double take_solver_work(Mat J) const { return linear_->take_work(J); }         ///< see linear_part.hpp
  double solver_memory(Mat J) const { return linear_->memory(J); }               ///< see linear_part.hpp
  void begin_solves(Mat J, double memory, bool for_one = false) const { linear_->begin(J, memory, for_one); }
  LinearEffort take_effort(Mat J, int solves) const { return linear_->take_effort(J, solves); } ///< see linear_part.hpp
  /// J = [d residual / d y; border^T], border (unknowns,). Collective.
  void jacobian(Vec y, Vec border, Mat J);

  /// Its transpose: [d residual / d Y^T, border; column^T, corner], into a matrix of that kind. Collective.
  void transposed_jacobian(Vec y, Vec border, Mat J);
  /// The same of D_k with the contacts as evaluated last, and any column (own coefficients) and border (own unknowns).
  /// Collective.
  void fill(Mat J, const DynamicStiffness &structure, const double *column, const double *border);

  /// Rigid motions that only the joint holds. While contacts leave one of them adrift, jacobian() holds the points'
  /// means by a part of their springs: Newton then finds the way back to contact, or the mean it started from.
  const LooseBody &loose_body() const { return loose_; }
  bool adrift() const { return adrift_; } ///< so it was when the Jacobian was evaluated last

  /// Products and contact forces at a motion, (own coefficients): what follows is of the motion evaluated last.
  /// Collective.
  void evaluate(const double *q);
  /// out (own coefficients) = D q + G - the loads, their means times `constant`, their harmonics times `varying`.
  void balance(const DynamicStiffness &structure, double constant, double varying, double *out) const;
  /// out (own coefficients) = derivative of D q by the frequency, eq (13).
  void by_frequency(const DynamicStiffness &structure, double *out) const { by_frequency(structure, of_, out); }
  const ContactForces &contact_forces() const { return forces_; }
  const std::vector<double> &contact_force() const { return force_; } ///< (own points, 3, 2H+1) G
  /// See loose_body(): what is added to the derivative of the means, (own contact dofs), or null. Collective.
  const double *holding();

  /// K q and M q of the motion evaluated last, (own coefficients).
  const std::vector<double> &stiffness_force() const { return of_.stiffness; }
  const std::vector<double> &inertia_force() const { return of_.inertia; }
  const std::vector<double> &damping_force() const { return of_.viscous; }       ///< C q of the dampers, or none
  const std::vector<double> &hysteretic_force() const { return of_.hysteretic; } ///< S q, likewise
  const Dampers *dampers() const { return linear_->dampers(); }                  ///< damping besides K and M, or none
  DynamicStiffness structure(double omega) const {                               ///< its D_k
    return DynamicStiffness(scaled_.damping, omega, setting_.damping);
  }
  Damping damping() const { return scaled_.damping.times(setting_.damping); } ///< scaled, at the value set last

  /// weights . d residual / d factor on all damping, at the motion y. Collective.
  double weighed_damping(Vec y, Vec weights);
  /// weights . d residual / d parameters of every own point, at the motion y, for weights like y. Collective.
  std::vector<ByParameter> weighed(Vec y, Vec weights);
  /// out = d residual / d that parameter, at y and what is set besides; its last entry is 0. Collective.
  void by_parameter(Vec y, const PathParameter &by, Vec out);
  /// out = d (weights . [d residual / dY along + d residual / dOmega]) / d [Y; Omega] at y, for vectors like y whose
  /// last entries do not count: by central differences along the motion of that step, exactly along the frequency.
  /// Collective.
  void differentiate_twice(Vec y, Vec along, double step, Vec weights, Vec out);
  /// Grazes of the own contact points at y, and the derivative of one's height by a parameter: of the own point of
  /// that number, or 0 where that is -1 and another rank owns it. Collective.
  std::vector<std::vector<Graze>> grazes(Vec y);
  double by_parameter(Vec y, int own_point, const Graze &graze, const PathParameter &by);

  /// What the own contact points did over the period at the motion evaluated last, in scaled units.
  const std::vector<Activity> &activity() const { return forces_.activity(); }

private:
  struct Products {                                 // (own coefficients) each
    std::vector<double> motion, stiffness, inertia; // q, K q, M q
    std::vector<double> viscous, hysteretic;        // C q and S q of the dampers, or empty
  };
  void evaluate_contact(const double *q); // unless done at this motion
  bool has_products(const double *q) const;
  void by_frequency(const DynamicStiffness &structure, const Products &of, double *out) const;
  void products(const double *q, Products &of, std::vector<double> *sums = nullptr);
  double go_to(const double *y, const double *border);
  bool stand_at(const double *y, std::vector<double> *more = nullptr);
  struct Stiffness { // of contact dofs: on average over the period, and closed and stuck
    std::vector<double> mean, springs;
  };
  Stiffness contact_stiffness() const;
  const double *hold_adrift(const Stiffness &of);
  void fit_courses(); // to the harmonics
  double shared_parameter(const double *own) const;
  void differentiate(const double *q, const PathParameter &by); // column_ = d residual / d that parameter
  double by_damping(std::size_t i) const;                       // d residual / d factor on all damping, at the products

  ScaledModel scaled_;
  Layout layout_;
  int harmonics_, samples_;
  LinearForm form_;
  std::vector<LoadCase> loads_, left_out_loads_;
  LooseBody loose_;
  bool adrift_ = false;
  ResponseParameter parameter_;
  std::shared_ptr<VariedPreload> preload_;
  Setting setting_;
  std::optional<double> value_;  // of the parameter, in setting_
  std::vector<double> constant_; // (3 own), or empty
  ContactForces forces_;
  std::vector<double> contact_; // (own points, 3, 2H+1) motion that forces_ was last evaluated at
  std::unique_ptr<LinearPart> linear_;
  Products of_;                       // the motion multiplied last
  std::vector<double> column_, held_; // of the Jacobian, see JacobianParts
  std::vector<double> force_;         // (own points, 3, 2H+1)
};

} // namespace dovetail
