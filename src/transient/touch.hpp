#pragma once
// One contact point over one step of time: its force as a power series while its state lasts, the instant at which it
// ends, and the state beyond (docs/theory/contact-laws.md, in continuous time).
//
// The cone's slider, slipping, is a differential equation of its own: k_t (x' - w') = T' and k_t w' = lambda T with
// lambda such that |T| = mu N,  T' = k_t x' - lambda T,  lambda = (T . k_t x' - mu^2 N N') / (mu N)^2.
#include <vector>

#include "contact/law.hpp"
#include "contact/law_traits.hpp"
#include "transient/series.hpp"

namespace dovetail {

/// What goes on at a contact point. Where there is no friction, only `closed` has a meaning.
struct TouchState {
  bool closed = false;
  std::array<int, 2> side{};     ///< of each slider: 0 sticks, else the sign of T while it slips
  bool slides = false;           ///< cone: the slider of both directions slips
  std::array<double, 2> along{}; ///< and T points there
  Memory w{};                    ///< where a slider stands; without meaning while it slips or the contact is open
  std::array<bool, 2> held{};    ///< as an aid, sliders that shall not slip, whatever the force; cone: the first
  std::array<double, 2> moved{}; ///< longest way of a slider between two places where it stuck; cone: the first
};

/// End of a state.
struct TouchEvent {
  enum class Kind { none, opens, lands, slips, sticks } kind = Kind::none;
  double at = 2;     ///< in parts of the step
  int direction = 0; ///< of the slider, Coulomb's law
  int side = 0;      ///< to which it slips
};

/// Displacements here are total ones, x + x_p, the normal one from the gap: closed where x[2] > 0.
class Touch {
public:
  /// mobility: (M^-1)_cc of the contact dofs t1, t2, n; shortest: a time in which little happens otherwise.
  Touch(const ContactPoint &point, const Standstill &rest, const std::array<double, 3> &mobility, double shortest);

  const std::array<double, 3> &origin() const { return origin_; } ///< displacement at standstill
  double rate() const { return rate_; }                           ///< frequency of the mass at hand on the springs

  /// Largest displacement about, by which round-off is told from events.
  void reach(double displacement);

  /// The state that displacement x, velocity v and slider w mean. A slider beyond its bound gives way.
  TouchState at(const double *x, const double *v, const Memory &w, const std::array<bool, 2> &held = {}) const;

  /// Term k of the force, from that of the displacement (3), of a closed point. k = 0, 1, ..., series_order in turn.
  void expand(const TouchState &state, int k, const double *x, double *g);
  void expand_open(int k, double normal) { x_[2][k] = normal; } ///< of an open one

  double longest(const TouchState &state) const; ///< step that these series are good for
  /// First event of the step; powers: of its length.
  TouchEvent next(const TouchState &state, const Series &powers, double before) const;
  /// Follows the state to time t of the step, and through an event there: x, v: displacement and velocity then.
  void advance(TouchState &state, double t, const TouchEvent &event, const std::array<double, 3> &x,
               const std::array<double, 3> &v) const;

  /// Position of the sliders: w, or x where they have no place of their own.
  Memory sliders(const TouchState &state, const double *x) const;

  // Derivatives (tangents.hpp), `width` of each; dx, dv: (3, width) of displacement and velocity; dw, de: (2, width),
  // Tangents::slider and along.
  /// Of what `at` made of x, v and w; dw: of w.
  void begin_tangents(const TouchState &state, const std::array<double, 3> &x, const std::array<double, 3> &v,
                      const Memory &w, const std::vector<double> &dx, const std::vector<double> &dv, double *dw,
                      double *de) const;
  /// Term k of those of the force, (3, width), after `expand` for all terms.
  void expand_tangents(const TouchState &state, int k, int width, const double *dx, const double *dw, const double *de,
                       double *dg);
  /// Whether the direction of slip goes on changing.
  bool turns(const TouchState &state) const { return state.closed && state.slides; }
  std::array<double, 2> turning(double t) const; ///< d/dt of that direction, at time t of the step
  /// Follows them to time t of the step, where a direction turns, and through an event there; state, x, v: beyond it.
  void advance_tangents(const TouchState &state, double t, const TouchEvent &event, const std::array<double, 3> &x,
                        const std::array<double, 3> &v, const std::vector<double> &dx, double *dw, double *de) const;
  /// Of `sliders`, (2, width).
  void slider_tangents(const TouchState &state, const std::array<double, 3> &x, const std::vector<double> &dx,
                       const double *dw, const double *de, double *out) const;

private:
  bool rubs(int d) const { return has_friction(point_.law) && mu_[d] > 0; }
  bool cone() const { return shares_slider(point_.law) && mu_[0] > 0; }
  void expand_cone(const TouchState &state, int k);
  void expand_cone_tangents(const TouchState &state, int k, int width, const double *dx, const double *de);
  void slid(int d, double side, double turn, int width, const double *dx, const double *de, double *out) const;
  void look(TouchEvent &event, TouchEvent::Kind kind, Series guard, const Series &powers, int d = 0, int s = 0) const;
  void look_at_cone(const TouchState &state, TouchEvent &event, const Series &powers) const;

  ContactPoint point_;
  Standstill rest_;
  std::array<double, 2> kt_, mu_;
  std::array<double, 3> origin_;
  double rate_, brief_, tiny_ = 0;
  std::array<Series, 3> x_{}, force_{};  // displacement, force T1, T2, N over the step; open: x_[2] alone
  Series power_{}, square_{}, lambda_{}; // cone: (mu N)^2 lambda, (mu N)^2, lambda
  std::vector<double> tangents_;         // cone: (8, order+1, width) of x1, x2, T1, T2, N, the three above
  bool frozen_ = false;                  // cone: so near landing or lift-off that the direction of slip is kept
};

} // namespace dovetail
