#pragma once
// The solution curve of one harmonic system.
#include "continuation/curve.hpp"
#include "problems/forced_response.hpp"
#include "problems/response_metric.hpp"

namespace dovetail {

class ResponseCurve : private ForcedResponse, public Curve {
public:
  /// As Curve.
  ResponseCurve(HarmonicSystem &followed, const NewtonSettings &newton, double unit, bool weighted,
                SolveCounts &counts);

  ResponseMetric &metric() { return static_cast<ResponseMetric &>(norm); }
  const ResponseMetric &metric() const { return static_cast<const ResponseMetric &>(norm); }

  /// Estimated distance to the curve that modes left out of the reduced model would lead to, as ErrorEstimate has it;
  /// NaN where the linear solver failed. Collective.
  double left_out(const CurvePoint &s);

  HarmonicSystem &system;

private:
  double step_of_left_out(const CurvePoint &s);

  double unit_;
  UniqueVec residual_, correction_;
};

/// The response's own data of a point. The point must have some.
ResponseData &data_of(CurvePoint &s);
const ResponseData &data_of(const CurvePoint &s);

} // namespace dovetail
