#pragma once
// The circular Coulomb cone |(T1, T2)| <= mu N over one period, from N samples. The two tangential directions share one
// slider in the plane, so nothing of the interval algebra of the other laws holds: derivatives are marched. Between two
// samples the motion is taken to be linear, and the force is exact for that (cone_step.hpp).
#include <array>
#include <vector>

#include "contact/activity.hpp"
#include "contact/fourier.hpp"
#include "contact/law.hpp"
#include "contact/linearisation.hpp"

namespace dovetail {

/// Law cone for one point, marched round the period from w_p until the memory closes its loop, the last round kept.
/// Holds scratch memory: one object per thread.
class ConeLaw {
public:
  ConeLaw(int harmonics, int samples);

  /// X, G (3, 2H+1); linear, unless null, gets its `dense` blocks. See ContactForces::evaluate.
  void evaluate(const ContactPoint &point, const Standstill &standstill, const double *X, double *G, Activity &activity,
                Linearisation *linear);

private:
  enum class State { open, stick, slip };

  static constexpr int most_rounds = 100;
  int rounds_to_close(const ContactPoint &point, const Standstill &standstill); // leaves the forces of the last round
  State step(const ContactPoint &point, const Standstill &standstill, int round, int sample, bool differentiate);
  void march(const ContactPoint &point, const Standstill &standstill, bool differentiate);
  static constexpr int inputs = 6; // of a step
  template <class Real> State advance(const ContactPoint &point, int sample);
  void chain(const std::array<std::array<double, inputs>, 2> &by, const double *then, const double *now);
  void slide(const ContactPoint &point, bool differentiate);
  void record(Activity &activity) const;
  void write_blocks(std::vector<double> &dense) const;

  Fourier fourier_;
  std::vector<double> motion_, force_; // (3, N): displacement, the normal one from x_n0; force
  std::vector<State> states_;          // (N)
  std::array<double, 2> T_{};          // trial, then force at the sample at hand
  std::vector<double> slopes_;         // (2, 3, 2H+1): d T / d X
  std::vector<double> sums_,
      pressures_; // (2, 2H+1, 3, 2H+1), (2H+1, 2H+1): d G / d X but for the scale of the analysis
};

} // namespace dovetail
