#pragma once
// Derivative of the forces of many points by their motions, at the motion evaluated last, or its transpose.
#include "contact/contact_forces.hpp"

namespace dovetail {

class ContactDerivative {
public:
  /// `forces` must outlive it.
  explicit ContactDerivative(const ContactForces &forces, bool transposed = false)
      : forces_(&forces), transposed_(transposed) {}

  const ContactForces &forces() const { return *forces_; }
  bool is_transposed() const { return transposed_; }
  int size() const { return forces_->size(); }
  const std::vector<ContactPoint> &points() const { return forces_->points(); }
  bool springs_only(int point) const { return forces_->springs_only(point); }

  /// Of the blocks that write() gives, of one point.
  const std::vector<BlockPlace> &places(int point) const { return block_places(points()[point].law, transposed_); }
  void write(int point, double *blocks) const;
  /// out = that times V, (points, 3, 2H+1) each.
  void multiply(const double *V, double *out) const;

private:
  const ContactForces *forces_;
  bool transposed_;
};

} // namespace dovetail
