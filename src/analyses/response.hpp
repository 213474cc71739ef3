#pragma once
// The response that is followed: a harmonic system, its curve, and what is watched of it. Another system of the same
// model, with other harmonics, may take its place.
#include <memory>
#include <string>

#include "analyses/branch.hpp"
#include "problems/amplitude.hpp"
#include "problems/response_curve.hpp"

namespace dovetail {

class Response {
public:
  /// `given` must outlive it. `unit`, `counts`: as for the curve.
  Response(HarmonicSystem &given, const NewtonSettings &newton, const BranchSettings &settings, double unit,
           SolveCounts &counts);

  HarmonicSystem &system() const { return *system_; }
  const Layout &layout() const { return system_->layout(); }
  ResponseCurve &curve() const { return *curve_; }
  ResponseMetric &metric() const { return curve_->metric(); }
  Amplitude amplitude(const CurvePoint &s) const { return (*meter_)(s.y, s.t); }

  /// The same model with other harmonics; and the curve of such a system.
  std::unique_ptr<HarmonicSystem> with(int harmonics) const;
  ResponseCurve curve_of(HarmonicSystem &system) const { return curve_of(system, unit_); }
  ResponseCurve curve_of(HarmonicSystem &system, double unit) const;
  /// That system from here on. Returns the one before, unless it was the one given. Collective.
  std::unique_ptr<HarmonicSystem> exchange(std::unique_ptr<HarmonicSystem> system);

  int asked_for() const { return asked_for_; } ///< harmonics, by the case
  /// Harmonics were raised to many more than the case has.
  bool iterations_are_expensive() const { return !to_tolerance_ && system_->harmonics() > 2 * asked_for_; }

  /// That rounding leaves a larger residual near that value than the case allows, in words that go on a sentence, or
  /// nothing. `residual`: with which Newton's method has ended there. Collective.
  std::string lost_to_rounding(double value, double residual) const;

  std::string parameter_name() const { return system_->parameter().kind().name; }
  std::string at_key() const { return is_sweep() ? "continuation.at" : "path.at"; }

private:
  bool is_sweep() const { return &system_->parameter().kind() == &frequency_parameter(); } // over the frequency
  void follow(HarmonicSystem &system);

  const NewtonSettings &newton_;
  const double unit_;
  const bool weighted_, to_tolerance_;
  const Watched watched_;
  const int asked_for_;
  SolveCounts &counts_;
  std::unique_ptr<HarmonicSystem> own_; // in place of the one given
  HarmonicSystem *system_ = nullptr;
  std::unique_ptr<ResponseCurve> curve_;
  std::unique_ptr<AmplitudeMeter> meter_;
};

} // namespace dovetail
