#pragma once
// Is a periodic motion stable, and if not, how does it lose stability?
//
// Two methods that fail in different ways are asked. The product of matrix exponentials (monodromy.hpp) is exact for
// the motion it is given, so what it errs by is the error of that motion: it is asked for the motion of harmonic
// balance and for a finer one, and the difference says how far it is to be trusted. Hill's method (hill.hpp) is
// consistent with harmonic balance itself, right about turning points and forgiving where there are few harmonics, but
// takes sliders as if they had no lag. It costs ten times as much, and is asked only where it may matter.
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

/// Whether judging a point takes no more time than computing it does. (Measured: five dofs, one point, H = 10: 0.03 ms
/// where nothing slips, 0.2 ms where it does, 1.5 ms with Hill's method, to some 1 ms for the point; 15 dofs, 4 points,
/// H = 5: 0.2, 1 and 7 ms to 3.3 ms.) It grows as the cube of dofs (2H+1) with Hill's method, and without as the number
/// of events times the cube of the dofs.
constexpr bool judged_cheaply(int dofs, int harmonics) { return dofs * (2 * harmonics + 1) <= 400; }

/// Whether StabilityTest is the one to take, and LargeStabilityTest (large_stability.hpp) for more than that.
constexpr bool judged_densely(int dofs) { return dofs <= 64; }

/// Judges points of one branch. For small models: everything is dense and done alike on every rank, in less than 200
/// MB.
class StabilityTest {
public:
  /// ComputeError if M is not positive definite.
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
