#pragma once
// The motion of the model through time. Between two contact events it is expanded into power series, long enough for
// the step to be exact to round-off, and every event is located as the zero of such a series: there is no step size on
// which the result depends, and stiff contacts only make the steps short while they are closed.
#include "transient/free_modes.hpp"
#include "transient/motion.hpp"
#include "transient/motion_state.hpp"
#include "transient/tangents.hpp"
#include "transient/touch.hpp"

namespace dovetail {

class Flow {
public:
  struct State {
    std::vector<double> eta, rate; ///< (n) coordinates of the free modes, and d/dt
    std::vector<TouchState> touch; ///< (points)
  };

  /// The error of one step stays below `tolerance` times the largest motion so far.
  Flow(const DenseModel &model, double omega, double tolerance = 1e-12);

  void set_omega(double omega); ///< and forgets how far the motion has reached: what follows depends on it alone
  State rest() const;           ///< the preload state
  State state(const MotionState &at) const;
  MotionState motion_state(const State &state) const;
  /// The same for coordinates of the free modes; held: TouchState::held of each point, or empty.
  State modal_state(std::vector<double> eta, std::vector<double> rate, const std::vector<Memory> &w,
                    const std::vector<std::array<bool, 2>> &held = {}) const;
  std::vector<Memory> sliders(const State &state) const;

  /// One period from theta = 0. False if the numbers are no longer finite or `work` is used up.
  bool period(State &state, int instants, Motion &motion);

  /// Tangents of a motion that begins at `state`, which came of sliders w, and depends on `numbers` numbers and omega:
  /// zeros, for the caller to set those of eta and rate and of w; then `begin` makes the others of them.
  Tangents tangents(int numbers) const;
  void begin(const State &state, const std::vector<Memory> &w, Tangents &tangents);
  /// The same period with them, exactly but for the tolerance; the steps may be shorter.
  bool period(State &state, Tangents &tangents);
  /// (padded numbers, 2 points) of `sliders`.
  Dense slider_tangents(const State &state, const Tangents &tangents) const;

  const DenseModel &model() const { return model_; }
  const FreeModes &modes() const { return modes_; }
  double omega() const { return omega_; }
  double reach() const { return reach_; } ///< largest contact displacement so far, at most
  double contact_rate() const;            ///< highest frequency of a contact on its springs
  long steps() const { return steps_; }   ///< so far
  double work = 1e300;                    ///< multiplications left, roughly

private:
  bool march(State &state, int instants, Motion *motion, Tangents *tangents);
  void lay_out(const State &state);
  void expand(const State &state, double time);
  double length(const State &state, double left) const;
  std::array<double, 3> at_contact(const double *eta, int point, std::array<double, 3> from = {}) const;
  void advance(State &state, double t, int touched, const TouchEvent &event);
  void note_size(const State &state);
  void evaluate(double t, double *eta, double *rate) const;
  void record(double t, int instant, Motion &motion);

  // flow_tangents.cpp
  void expand_tangents(const State &state, double time, const Tangents &tangents);
  double tangent_length(const Tangents &tangents) const;
  void advance_tangents(const State &state, double t, int touched, const TouchEvent &event, Tangents &tangents);
  void turn_end(const State &state, double t, Tangents &tangents);
  std::vector<double> acceleration(double t) const;
  std::vector<double> contact_tangents(const Dense &eta, int point) const;
  double *term(int k) { return &eta_[static_cast<std::size_t>(k) * modes_.count]; }
  const double *term(int k) const { return &eta_[static_cast<std::size_t>(k) * modes_.count]; }

  const DenseModel &model_;
  FreeModes modes_;
  std::vector<Touch> touches_;
  std::vector<std::vector<int>> driven_; // harmonics that each load has, few of all where these are many
  std::vector<Series> courses_;          // f(t) of each load over the step
  double omega_, tolerance_;
  double size_ = 0, reach_ = 0; // largest |eta| so far, or what the force alone would make; in displacements
  double work_of_step_;
  long steps_ = 0;
  std::vector<bool> closed_;      // points, as these are laid out for:
  int seen_columns_ = 0;          // padded
  std::vector<double> seen_;      // (n, seen_columns) displacements that matter: t1, t2, n, or n where it is open
  std::vector<double> pulls_;     // (3 closed points, padded n) what their forces do to the modes
  std::vector<double> rest_pull_; // (n) what those of the preload do
  std::vector<double> eta_, x_, g_, now_; // (order+1, n), (seen_columns), (3 points), (2 n)
  std::vector<double> pull_;              // (padded n)
  std::vector<double> tangent_terms_;     // (order+1, n, padded numbers)
};

} // namespace dovetail
