// The steady state that time integration finds, at a next frequency or at the first one: small models only.
#include "recovery/recovery.hpp"

namespace dovetail {
namespace {

class Integration : public RecoveryStrategy {
  bool handles(Failure::Kind kind) const override { return kind != Failure::Kind::nowhere; }

  bool attempt(const Failure &failure, RecoveryContext &context) const override {
    if (failure.kind == Failure::Kind::no_start) return context.integrate_at(failure.from, 1);
    if (context.jumps() >= most_jumps) return false;
    const std::vector<double> values = ahead(context.sweep(), failure.from, {1e-3, 1e-2, 5e-2, 0.2, 0.4});
    for (std::size_t i = 0; i < values.size(); ++i)
      if (context.integrate_at(values[i], 1.0 / static_cast<double>(values.size() - i))) {
        context.go_on(failure, true);
        return true;
      }
    return false;
  }
};

} // namespace

const RecoveryStrategy &integration() {
  static const Integration one;
  return one;
}

} // namespace dovetail
