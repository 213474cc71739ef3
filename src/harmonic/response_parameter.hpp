#pragma once
// What the last unknown of the harmonic-balance equations stands for.
#include "contact/path_parameter.hpp"

namespace dovetail {

class ResponseParameter {
public:
  /// `omega`: the frequency, scaled, where it is not the parameter.
  explicit ResponseParameter(const PathParameter &kind = frequency_parameter(), double omega = 0)
      : kind_(&kind), omega_(omega) {}

  const PathParameter &kind() const { return *kind_; }
  /// The equations at a value, scaled.
  Setting at(double value) const {
    Setting setting;
    setting.omega = omega_;
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
  double omega_;
};

} // namespace dovetail
