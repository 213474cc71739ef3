// Until time integration and stability have rooms of their own: no rung of the ladder, and no verdict. To be deleted
// together with this folder when they are here.
#include "stability/stability.hpp"
#include "transient/steady_state.hpp"
namespace dovetail {
struct StabilityTest::Workspace {};
StabilityTest::StabilityTest(const DenseModel &) {}
StabilityTest::~StabilityTest() {}
Stability StabilityTest::judge(const std::vector<double> &, double) { return {}; }
SteadyState steady_state(const DenseModel &, double, const std::vector<double> &, const IntegrationSettings &) {
  return {};
}
} // namespace dovetail
