#pragma once
// Is a periodic motion stable, and if not, how does it lose stability?
//
// Two methods that fail in different ways are asked. The product of matrix exponentials (monodromy.hpp) is exact for
// the motion it is given, so what it errs by is the error of that motion: it is asked for the motion of harmonic
// balance and for a finer one, and the difference says how far it is to be trusted. Hill's method (hill.hpp) is
// consistent with harmonic balance itself, right about turning points and forgiving where there are few harmonics, but
// knows no finer changes than its waves. It costs ten times as much, and is asked only where it may matter.
#include <memory>

#include "harmonic/dense_model.hpp"

namespace dovetail {

struct Stability {
  /// Uncertain where the two methods disagree.
  enum class Verdict { uncertain = -1, unstable = 0, stable = 1 } verdict = Verdict::uncertain;
  /// What the largest multiplier stands for: +1 the motion jumps, -1 the period doubles, a pair off the real axis a
  /// second frequency appears. None where stable.
  enum class Kind { none, jump, period_doubling, second_frequency } kind = Kind::none;
  double multiplier = 0; ///< largest modulus, by the method that is trusted more at this point
  double growth = 0;     ///< log(multiplier) / (2 pi): largest real part of an exponent over Omega
};

/// Whether StabilityTest is the one to take, and LargeStabilityTest (large_stability.hpp) for more than that.
constexpr bool judged_densely(int dofs) { return dofs <= 64; }

/// Judges points of one branch. For small models: everything is dense and done alike on every rank, in less than 200
/// MB.
class StabilityTest {
public:
  /// InputError if M is not positive definite. ComputeError if damping is not viscous.
  explicit StabilityTest(const DenseModel &model);
  ~StabilityTest();

  /// coefficients (n, 2H+1), scaled, as all_coefficients gives them; of any H.
  Stability judge(const std::vector<double> &coefficients, double omega);

  /// What each method said last: growth, and NaN if it was not asked or had no answer.
  struct Opinions {
    double by_monodromy, doubt; ///< and how much a finer motion changed it
    double by_hill;
  };
  const Opinions &opinions() const;

private:
  struct Workspace;
  std::unique_ptr<Workspace> work_;
};

} // namespace dovetail
