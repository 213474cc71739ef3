#include "results/sensitivity_record.hpp"

#include <cmath>
#include <limits>

#include "results/gather.hpp"

namespace dovetail {
namespace {

// The derivative from value times derivative.
double by_value(double product, double value) {
  return value != 0 ? product / value : product == 0 ? 0 : std::numeric_limits<double>::quiet_NaN();
}

SlopeRecord collect(const PeakSlope &slope, const HarmonicSystem &system, double unit) {
  const Scales &s = system.scales();
  const double stiffness = std::pow(s.modal * s.frequency / s.contact, 2); // of one, in user units
  std::vector<double> own;
  for (std::size_t p = 0; p < slope.points.size(); ++p) {
    const ByParameter &by = slope.points[p];
    const ContactPoint &point = system.contact()[p];
    own.push_back(by_value(unit * by.normal_stiffness, stiffness * point.kn));
    own.push_back(unit * by.gap / s.contact);
    for (int d = 0; d < 2; ++d) {
      own.push_back(by_value(unit * by.tangential_stiffness[d], stiffness * point.kt[d]));
      const bool unknown = has_friction(point.law) && point.mu[d] == 0;
      own.push_back(unknown ? std::numeric_limits<double>::quiet_NaN() : by_value(unit * by.friction[d], point.mu[d]));
    }
  }
  const std::vector<double> all = gather(system.layout().comm, own); // (N_x, 6)
  SlopeRecord out;
  for (std::size_t i = 0; i < all.size(); i += 6) {
    out.normal_stiffness.push_back(all[i]), out.gap.push_back(all[i + 1]);
    for (int d = 0; d < 2; ++d)
      out.tangential_stiffness.push_back(all[i + 2 + 2 * d]), out.friction.push_back(all[i + 3 + 2 * d]);
  }
  out.force = unit * slope.force, out.preload = unit * slope.preload, out.damping = unit * slope.damping;
  return out;
}

} // namespace

SensitivityRecord collect(const PeakSensitivity &peak, const HarmonicSystem &system, double unit, int point) {
  const double w0 = system.scales().frequency;
  return {point, peak.omega * w0, peak.amplitude * unit, collect(peak.amplitude_by, system, unit),
          collect(peak.omega_by, system, w0)};
}

} // namespace dovetail
