#pragma once
// Numbers that rule what is tried where steps lead nowhere.

namespace dovetail {

constexpr double least_patience = 400; // Newton iterations for a curve that does not go ahead,
constexpr double dear_patience = 100;  // where they are dear; or so many that
constexpr double most_wound = 3e5;     // unknowns were corrected in all
constexpr double first_skip = 0.01;    // of the sweep, left out when it is left again, twice as much each time
constexpr int most_stays = 8;          // times that no way on is found for a curve that winds in time
constexpr int most_leaps = 20, most_integrations = 100;
constexpr int anchored = 16;             // points between those that may be gone back to,
constexpr int most_repeats = 6;          // times, not twice at the same place, for as many points as
constexpr int careful_points = 200;      // that, with steps
constexpr double careful_part = 1.0 / 6; // as long
constexpr double most_beyond = 0.5; // of the sweep, and of its first frequency: so far a curve is followed before it

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

} // namespace dovetail
