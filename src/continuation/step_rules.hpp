#pragma once
// Numbers that rule the steps of the continuation. Lengths are in the weighted norm, where 1 is the largest motion so
// far or the whole sweep.
#include <cmath>

namespace dovetail {

constexpr double longest_step = 0.1;
constexpr double longest_omega_step = 0.01;   // of the sweep: a resonance narrower than this could be stepped over
constexpr double longest_motion_step = 0.25;  // of the motion at hand, which after a resonance is far below the largest
constexpr double shortest_motion_step = 1e-3; // that limit does not hold a curve up where the motion passes zero
constexpr double shortest_step = 1e-7;
constexpr double step_after = 1e-3; // another system, or a leap
constexpr double most_angle = 0.64; // between the tangents before and after a step [rad]
constexpr double most_astray = 0.1; // by which a step may point away from the tangent more than the curve turns [rad],
constexpr double most_astray_sampled = 0.8; // where sampled contact forces make teeth that are not worth following
constexpr double most_off = 0.05; // of a step, by which its middle may lie off the curve; smooth ones: 1e-3 and less
constexpr double most_correction = 2; // distance from predicted to converged point, in steps, where a corner may be
constexpr double aimed_angle = 0.25;  // between tangents [rad]
constexpr int aimed_newton = 4, most_newton = 8;
constexpr int most_refinements = 8;        // of the harmonics, for one step
constexpr double least_newton_step = 1e-4; // shorter steps may take newton.max_iterations
constexpr double corner_step = 2e-3;       // shorter steps that fail may be at a corner of the curve
constexpr int most_waiting = 3;            // further halvings, where iterations are dear and that was in vain
constexpr double close_to_corner = 1e-4;   // so near, both sides of a corner are tried
constexpr double most_miss = 0.05;         // of the tangents' lines at a corner, of the way there and back
constexpr int many_bends = 12;             // turning points and corners
constexpr double crowded_part = 0.03;      // of the sweep
constexpr double creeping_part = 0.01;     // of the sweep
constexpr long most_creeping = 1000;       // Newton iterations within it, unless the curve is as smooth as
constexpr int few_bends = 6;               // that: narrow peaks are
constexpr const char *bends_often = "the curve bends again and again";
constexpr double least_ahead = 0.01;   // of the sweep, for a curve that goes on;
constexpr double least_patience = 400; // Newton iterations for one that does not,
constexpr double dear_patience = 100;  // where they are dear; or so many that
constexpr double most_wound = 3e5;     // unknowns were corrected in all; half of it
constexpr int most_halved = 3;         // each time that it was left before, until it went on by
constexpr double enough_ahead = 0.05;  // of the sweep
constexpr double first_skip = 0.01;    // of the sweep, left out when it is left again, twice as much each time
constexpr int most_stays = 8;          // times that no way on is found for a curve that winds in time
constexpr int most_leaps = 20, most_integrations = 100;
constexpr int anchored = 16;             // points between those that may be gone back to,
constexpr int most_repeats = 6;          // times, not twice at the same place, for as many points as
constexpr int careful_points = 200;      // that, with steps
constexpr double careful_part = 1.0 / 6; // as long
constexpr double nothing = 1e-6;         // part of a step
constexpr int enough_still = 3;          // steps along which nothing but mean positions changes
constexpr double most_beyond = 0.5; // of the sweep, and of its first frequency: so far a curve is followed before it
constexpr double straight = 0.3;    // angle [rad] and correction [steps] up to which a curve runs on smoothly

// Of the time integration that helps out.
constexpr int most_integrated = 300;  // dofs
constexpr int most_periods = 4000;    // little damping takes many
constexpr double brief_work = 2e10;   // where it is one way of several
constexpr int patient_periods = 8000; // where it is the last way, begun at rest at
constexpr int seeds = 8;              // frequencies, closer to each other where the curve was left

constexpr double other_places = 0.618, nearer = 0.8; // shares by which they move each time that all were in vain

// Harmonics for a motion of integration's that is no solution with fewer, in parts of 2 omega_contact / Omega. Of 40
// such motions of six scenes Newton's method arrived at 19 with 1, at 37 with 1.4 and at all with 2, in 20 iterations
// at most.
constexpr double enough_parts = 1.4, ample_parts = 2;

// Times newton.max_iterations, without a line search, for leaps where there are more than twice the case's harmonics,
// and with ample ones: of 87 solutions reached there from what integration had found, 73 took no more. From the last
// point 1 in 262 leaps went well there.
constexpr double impatient_newton = 0.7;

constexpr int patient_newton = 3; // times newton.max_iterations, for a first point that nothing else has led to

/// What successive halvings of a step tell. Halving makes angle and correction of a smooth curve 1/2 and 1/4 as large;
/// at a corner the angle stays and the correction halves, at a jump to another branch both stay.
class Halvings {
public:
  struct Measure { // how far the curve turned within a trial step, and how far the solution lay from the prediction
    double angle = 0, correction = 0; // [rad], [steps]
    double allowed = most_astray;     // [rad]
    /// Where the step points elsewhere although the tangents agree, it led to another piece of the curve.
    bool refused() const { return angle > most_angle || std::atan(correction) > angle + allowed; }
  };

  /// True if this step and the one before it show a corner that may be taken as it is.
  bool add(const Measure &now) {
    const bool alike =
        last_.refused() && now.angle > ratio * last_.angle && now.correction < 2 * ratio * last_.correction;
    alike_ = alike ? alike_ + 1 : 0;
    last_ = now;
    return alike_ >= 2;
  }

private:
  static constexpr double ratio = 0.75;
  Measure last_;
  int alike_ = 0;
};

} // namespace dovetail
