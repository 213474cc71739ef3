// A first point from the solution with one harmonic, then with more and more.
#include "recovery/recovery.hpp"

namespace dovetail {
namespace {

class FewerHarmonics : public RecoveryStrategy {
  bool handles(Failure::Kind kind) const override { return kind == Failure::Kind::no_start; }

  bool attempt(const Failure &failure, RecoveryContext &context) const override {
    return context.solve_by_simpler(failure.from);
  }
};

} // namespace

const RecoveryStrategy &fewer_harmonics() {
  static const FewerHarmonics one;
  return one;
}

} // namespace dovetail
