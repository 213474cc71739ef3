#pragma once
// Forces of many contact points over one period, and their derivatives. The only door to the contact laws for
// everything that moves; no MPI, no PETSc. One object per rank, for the points it owns.
#include <array>
#include <memory>
#include <vector>

#include "contact/activity.hpp"
#include "contact/contact_change.hpp"
#include "contact/graze.hpp"
#include "contact/law.hpp"
#include "contact/linearisation.hpp"

namespace dovetail {

class ContactForces {
public:
  /// samples: N >= 2H+1, or `exactly`; points of law cone, which has no closed form, are then sampled enough_samples.
  ContactForces(std::vector<ContactPoint> points, std::vector<Standstill> standstill, int harmonics, int samples);
  ~ContactForces();
  ContactForces(ContactForces &&) noexcept;

  int size() const { return static_cast<int>(points_.size()); }
  int width() const { return 2 * harmonics_ + 1; } ///< coefficients of a motion
  const std::vector<ContactPoint> &points() const { return points_; }
  const std::vector<Standstill> &standstill() const { return standstill_; }
  /// Other parameters of the same laws, and what they stand on. Forces wait for the next motion.
  void change(std::vector<ContactPoint> points, std::vector<Standstill> standstill);

  /// X (points, 3, 2H+1): motion measured from the standstill, rows t1, t2, n; G the same shape: coefficients of
  /// g(x + x_p) - g(x_p), NaN where X is not finite. Without `derivative`, write() and multiply() must wait for the
  /// next.
  void evaluate(const double *X, double *G, bool derivative = true);

  const Linearisation &derivative(int point) const { return linear_[point]; } ///< at the last motion evaluated
  /// The same: blocks of one point (Linearisation::write), or of all
  /// points times V (points, 3, 2H+1).
  void write(int point, double *blocks) const { linear_[point].write(points_[point], blocks); }
  void write(int point, const int *which, int count, double *blocks) const {
    linear_[point].write(points_[point], which, count, blocks);
  }
  void multiply(const double *V, double *out) const;

  /// out (points, 3, 2H+1): derivative of the forces by a parameter, at the last motion evaluated, which was X.
  /// (points) each: `equivalent` to it, and by how much it moves the sliders of the standstill.
  void by_parameter(const double *X, const std::vector<EquivalentMotion> &equivalent, const std::vector<Memory> &memory,
                    double *out) const;

  /// weights . d(forces of a point) / d(its parameters), at that motion; X, weights (3, 2H+1) of the point.
  ByParameter weighed(int point, const double *X, const double *weights) const;

  /// Where sliders of a point all but slip at the motion X (3, 2H+1) of the point; none where the law is not exact.
  std::vector<Graze> grazes(int point, const double *X);
  /// Derivative of a graze's height by a parameter; `memory`: by how much it moves the slider of the standstill.
  double by_parameter(int point, const double *X, const Graze &graze, const EquivalentMotion &equivalent,
                      const Memory &memory) const;

  /// True if that derivative is springs only: stuck_springs(), the point being closed and stuck all through the period.
  bool springs_only(int point) const { return linear_[point].springs_only || points_[point].law == Law::bilateral; }

  /// By how much the mean forces of a point, t1, t2, n, follow its mean displacements at the last evaluated motion
  /// [N/m]: 0 where it is open, or slips, all round.
  std::array<double, 3> mean_stiffness(int point) const { return linear_[point].mean_stiffness(points_[point]); }

  const std::vector<Activity> &activity() const { return activity_; } ///< at the last evaluated motion

private:
  struct Laws;
  std::vector<ContactPoint> points_;
  std::vector<Standstill> standstill_;
  int harmonics_;
  std::unique_ptr<Laws> laws_;
  std::vector<int> exact_, sampled_, cone_; // numbers of the points that go each way; the rest is linear
  std::vector<Linearisation> linear_;
  std::vector<Activity> activity_;
};

} // namespace dovetail
