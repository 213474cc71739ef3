#pragma once
// Laws with independent directions over one period, from N samples: points side by side in vector lanes.
#include <cstdint>
#include <vector>

#include "contact/activity.hpp"
#include "contact/fourier.hpp"
#include "contact/law.hpp"
#include "contact/linearisation.hpp"

namespace dovetail {

/// Laws coulomb and unilateral, marched twice round the period from w_p, the second round kept. Holds scratch memory:
/// one object per thread.
class SampledLaw {
public:
  SampledLaw(int harmonics, int samples);

  /// For each of `count` points (numbers `which` in the arrays that follow): X, G (points, 3, 2H+1), activity and,
  /// unless null, linear. See ContactForces::evaluate.
  void evaluate(const int *which, int count, const ContactPoint *points, const Standstill *standstill, const double *X,
                double *G, Activity *activity, Linearisation *linear);

private:
  using Words = std::uint64_t *; // one bit per sample, 64 to a word

  // States of one point, a bit per sample: in contact, and slip with T = +mu N (forth) and -mu N (back) in both rounds.
  struct States {
    Words closed, forth[2][2], back[2][2]; // [round][direction]
  };
  // What the slider of a stick interval was last set by. Slip: of that sign, at that sample; landing (sign 0): between
  // that sample and the one before; sample -1: by nothing, it is still at w_p.
  struct Anchor {
    int sample, sign;
  };
  struct Stick { // samples [begin, end)
    int begin, end;
    Anchor anchor;
  };

  void march(const int *which, int lanes, const ContactPoint *points, const Standstill *standstill, const double *X);
  void land();
  void take_states(int lane, bool friction);
  bool eventless() const;
  void differentiate(const ContactPoint &point, int lane, const double *X, Linearisation &linear);
  void differentiate(const ContactPoint &point, int lane, int direction, const double *X, Linearisation &linear);
  Anchor anchor_before(int direction, int sample) const;
  void add_run(const ContactPoint &point, int lane, int direction, const Stick &stick, const double *X,
               Linearisation &linear) const;

  Fourier fourier_;
  MaskTable masks_;
  WideFourier wide_;
  int words_;                                      // ceil(N / 64)
  LaneArray<double> coefficients_;                 // (3, 2H+1): motion, then force
  LaneArray<double> motion_;                       // (3, N): t1, t2, x_n - x_n0
  LaneArray<double> force_;                        // (3, N)
  LaneArray<std::uint64_t> closed_, forth_, back_; // (words), (2 rounds, 2 directions, words)
  std::vector<std::uint64_t> state_words_;         // storage of states_
  States states_;
  std::vector<Stick> sticks_;
};

} // namespace dovetail
