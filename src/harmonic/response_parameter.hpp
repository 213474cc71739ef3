#pragma once
// What the last unknown of the harmonic-balance equations stands for.
#include "contact/path_parameter.hpp"

namespace dovetail {

class ResponseParameter {
public:
  /// `omega`: the frequency, scaled, where it is not the parameter.
  explicit ResponseParameter(const PathParameter &kind = frequency_parameter(), double omega = 0)
      : kind_(&kind), changes_joint_(kind.changes_joint) {
    others_.omega = omega;
  }
  /// `others`: all else that is set.
  ResponseParameter(const PathParameter &kind, const Setting &others, bool changes_joint)
      : kind_(&kind), others_(others), changes_joint_(changes_joint) {}
  /// The same while another parameter, too, has a value, scaled.
  ResponseParameter beside(const PathParameter &other, double value) const {
    ResponseParameter both = *this;
    other.set(both.others_, value);
    both.changes_joint_ = changes_joint_ || other.changes_joint;
    return both;
  }

  const PathParameter &kind() const { return *kind_; }
  /// Whether the joint may be another than that of the case.
  bool changes_joint() const { return changes_joint_; }
  /// The equations at a value, scaled.
  Setting at(double value) const {
    Setting setting = others_;
    kind_->set(setting, value);
    return setting;
  }
  /// Derivative of that by the value.
  Setting slope() const {
    Setting setting{0, 0, 0, 0, {0, {0, 0}, {0, 0}, 0}};
    kind_->set(setting, 1);
    return setting;
  }

private:
  const PathParameter *kind_;
  Setting others_;
  bool changes_joint_;
};

} // namespace dovetail
