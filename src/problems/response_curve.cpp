#include "problems/response_curve.hpp"

#include <algorithm>
#include <cmath>

#include "harmonic/left_out_forces.hpp"

namespace dovetail {

ResponseCurve::ResponseCurve(HarmonicSystem &followed, const NewtonSettings &newton, double unit, bool weighted,
                             SolveCounts &counts)
    : ForcedResponse(followed), Curve(static_cast<ForcedResponse &>(*this), newton, unit, weighted, counts),
      system(followed), unit_(unit), residual_(followed.unknowns()), correction_(followed.unknowns()) {}

double ResponseCurve::left_out(const CurvePoint &s) {
  const Vec r = residual_, c = correction_;
  const double motion = std::sqrt(swing_product(system.layout(), s.y, s.y)), own = left_out_forces(system, s.y, r);
  if (motion == 0) return 0;
  if (!correct(s, r, c)) return std::nan("");
  // across the curve: what lies along it does not count
  const auto product = [&](Vec a, Vec b) {
    return swing_product(system.layout(), a, b) / (motion * motion) +
           system.parameter_in(a) * system.parameter_in(b) / (unit_ * unit_);
  };
  const double along = product(c, s.t), across = product(c, c) - along * along / product(s.t, s.t);
  return std::hypot(std::sqrt(std::max(0.0, across)),
                    system.layout().modes > 0 ? own / motion : 0); // without modes they have no scale
}

ResponseData &data_of(CurvePoint &s) { return static_cast<ResponseData &>(*s.data); }
const ResponseData &data_of(const CurvePoint &s) { return static_cast<const ResponseData &>(*s.data); }

} // namespace dovetail
