#pragma once
// The equations of the contact preload (eq 7), and Newton's method on them.
#include <string>
#include <vector>

#include "contact/law.hpp"
#include "preload/preload_tangent.hpp"

namespace dovetail {

/// load * R + K_xx x + g(x) = 0. Vectors: (3 own each). All that is called here is collective.
class PreloadProblem {
public:
  /// Both must outlive it. `contact` may change between two solves.
  PreloadProblem(const ReducedModel &model, const std::vector<ContactPoint> &contact);

  /// From x by plain Newton; else from the joint held closed and stuck: at once, loaded in steps, with friction
  /// lowered in steps. False where nothing helps, and then x is what it was. `note` receives a line in words when
  /// more than plain Newton was needed. The same bits whatever was found before.
  bool find(std::vector<double> &x, double load, std::string &note);
  /// Each find() after this begins with factors of the stiffness at x, of the contact as it is now.
  void keep_factors(const std::vector<double> &x) { tangent_.keep(slopes(x)); }
  /// -(K_xx + dg/dx)^-1 change, at x. Not numbers where that has no inverse.
  std::vector<double> follow(const std::vector<double> &x, const std::vector<double> &change);
  int factorisations() const { return tangent_.factorisations(); } ///< of K_xx + dg/dx, so far

private:
  struct State { // at an x
    std::vector<double> residual;
    std::vector<PreloadTangent::Slope> slopes;
    double left = 0, force = 0; // sizes of the residual and of the forces at work
  };
  State at(const std::vector<double> &x, double load, bool stuck) const;
  std::vector<PreloadTangent::Slope> slopes(const std::vector<double> &x) const;
  bool solve(std::vector<double> &x, double load, bool stuck);
  bool load_in_steps(std::vector<double> &x, double load);
  bool lower_friction(std::vector<double> &x, double load);
  StaticForce law(std::size_t p, const double *x, bool stuck) const;

  const ReducedModel &model_;
  const std::vector<ContactPoint> &contact_;
  PreloadTangent tangent_;
  double friction_ = 1; // a factor on that of all points
};

} // namespace dovetail
