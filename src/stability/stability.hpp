#pragma once
// Is a periodic motion stable, and if not, how does it lose stability?
#include <memory>

#include "harmonic/dense_model.hpp"

namespace dovetail {

struct Stability {
  enum class Verdict { uncertain = -1, unstable = 0, stable = 1 } verdict = Verdict::uncertain;
  /// What the largest multiplier stands for: +1 the motion jumps, -1 the period doubles, a pair off the real axis a
  /// second frequency appears.
  enum class Kind { none, jump, period_doubling, second_frequency } kind = Kind::none;
  double multiplier = 0; ///< largest modulus, by the method that is trusted more at this point
  double growth = 0;     ///< largest real part of an exponent, over Omega: negative where stable
};

/// Judges points of one branch. For small models: everything is dense and done alike on every rank.
class StabilityTest {
public:
  explicit StabilityTest(const DenseModel &model);
  ~StabilityTest();

  /// coefficients (n, 2H+1), scaled, as all_coefficients gives them.
  Stability judge(const std::vector<double> &coefficients, double omega);

private:
  struct Workspace;
  std::unique_ptr<Workspace> work_;
};

} // namespace dovetail
