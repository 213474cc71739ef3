#include "recovery/recovery.hpp"

namespace dovetail {

std::vector<double> ahead(const RecoveryContext::Sweep &sweep, double from, const std::vector<double> &parts) {
  const double range = sweep.to - sweep.from;
  const auto between = [](double w, double a, double b) { return (w - a) * (w - b) < 0; };
  std::vector<double> out;
  for (const double part : parts) {
    double next = from + part * range;
    const bool last = (next - sweep.to) * range >= 0;
    if (last) next = sweep.to;
    double nearest = next;
    for (const double w : sweep.at)
      if (between(w, out.empty() ? from : out.back(), nearest)) nearest = w;
    if (nearest != next) out.push_back(nearest);
    out.push_back(next);
    if (last) break;
  }
  return out;
}

bool recover(const Strategies &strategies, const Failure &failure, RecoveryContext &context) {
  for (const Strategy *one : strategies.list()) {
    if (!one->object().handles(failure.kind)) continue;
    if (one->object().attempt(failure, context)) return true;
    if (context.interrupted()) return false;
  }
  return false;
}

} // namespace dovetail
