#pragma once
// What a contact point did over one period.
namespace dovetail {

struct Activity {
  double open = 0;        ///< share of the period without contact
  double slip = 0;        ///< share in which it slips in at least one direction; the rest sticks
  int events = 0;         ///< lift-offs, landings, slip onsets and ends of slip, over both directions
  double dissipation = 0; ///< energy taken from the structure per period [J]

  double stick() const { return 1 - open - slip; }
};

/// Energy per period [J] that forces G (3, 2H+1) [N] take from a motion X (3, 2H+1) [m]: the integral of g dx.
double dissipation(int harmonics, const double *X, const double *G);

} // namespace dovetail
