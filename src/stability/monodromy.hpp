#pragma once
// What becomes of a small change of a periodic motion in one period: the structure is linear between the instants at
// which some contact point changes its state, so the answer is a product of matrix exponentials, exact for the motion
// given. The sliders are states as well: they remember.
#include "harmonic/dense_model.hpp"
#include "stability/contact_history.hpp"
#include "support/dense.hpp"

namespace dovetail {

class Monodromy {
public:
  /// InputError if M is not positive definite. ComputeError if damping is not viscous.
  explicit Monodromy(const DenseModel &model);

  /// Eigenvalues of the map over one period; the largest are those of changes that matter. Sliders that never move are
  /// no states, and the values 1 of rigid displacements that nothing resists are made 0. Empty if LAPACK fails.
  std::vector<std::complex<double>> multipliers(const ContactHistory &history, double omega);
  /// How many of those were made 0: displacements, and drifts of those that not even friction resists.
  int indifferent() const { return static_cast<int>(indifferent_.size()); }

private:
  void follow(const ContactHistory &history, double omega);
  void set_held(const ContactHistory &history, int interval);
  void assemble(const Answer *answers);
  void apply_holds(const ContactHistory &history, int interval);
  void find_indifferent(const ContactHistory &history);
  Dense unfelt(const ContactHistory &history, bool held_too) const;

  int n_, points_;
  Damping damping_;
  std::vector<ContactPoint> contact_;
  std::vector<double> stiffness_; // (n) of the modes of K and M without contact
  std::vector<double> viscous_;   // (n, n) what C couples them by, besides; or empty
  Dense shape_;                   // (n, 3 points): x = shape^T q, q in these modes
  int rigid_ = 0;                 // the first so many modes have no stiffness
  double omega_ = 1, speed_ = 1;  // q' is divided by speed, for balance
  std::vector<int> sliders_;      // that are states when the period begins
  std::vector<int> held_;         // that are in the interval at hand
  Dense rate_, block_, moved_;    // of [q; q' / speed; v of the held sliders]
  Dense state_;                   // the same with v of all sliders; a column for each state at the beginning
  Dense map_;                     // over the whole period
  std::vector<std::vector<double>> indifferent_; // orthonormal states that stay what they are
  Exponential exponential_;
};

} // namespace dovetail
