// The solution at a next frequency, by Newton's method from the last point or from rest: beyond a gap, it may be.
#include "recovery/recovery.hpp"

namespace dovetail {
namespace {

class Jump : public RecoveryStrategy {
  bool handles(Failure::Kind kind) const override {
    return kind != Failure::Kind::no_start && kind != Failure::Kind::nowhere;
  }

  bool attempt(const Failure &failure, RecoveryContext &context) const override {
    if (context.jumps() >= most_jumps) return false;
    for (const double value : ahead(context.sweep(), failure.from, {1e-4, 1e-3, 1e-2, 5e-2, 0.2, 0.4}))
      if (context.solve_at(value)) {
        context.go_on(failure, false);
        return true;
      }
    return false;
  }
};

} // namespace

const RecoveryStrategy &jump() {
  static const Jump one;
  return one;
}

} // namespace dovetail
