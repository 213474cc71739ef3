// A first point at another frequency: the other end of the sweep, then places between.
#include "recovery/recovery.hpp"

namespace dovetail {
namespace {

class Elsewhere : public RecoveryStrategy {
  bool handles(Failure::Kind kind) const override { return kind == Failure::Kind::nowhere; }

  bool attempt(const Failure &, RecoveryContext &context) const override {
    const RecoveryContext::Sweep sweep = context.sweep();
    if (sweep.from == sweep.to) return false;
    if (context.begin_at(sweep.to, sweep.from)) return true;
    for (const double part : {0.02, 0.2, 0.35, 0.5, 0.65, 0.8})
      if (context.begin_at(sweep.from + part * (sweep.to - sweep.from), sweep.to)) return true;
    return false;
  }
};

} // namespace

const RecoveryStrategy &elsewhere() {
  static const Elsewhere one;
  return one;
}

} // namespace dovetail
