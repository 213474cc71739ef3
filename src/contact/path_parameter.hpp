#pragma once
// What a curve can be followed over. One row of a table for each parameter: its name, and what it sets.
#include <array>
#include <string>
#include <vector>

namespace dovetail {

/// What the equations are made of besides the structure; all zero in a derivative by a parameter.
struct Setting {
  double omega = 0;   ///< frequency
  double load = 1;    ///< factor on the load
  double preload = 1; ///< factor on R, the preload
  double damping = 1; ///< factor on all damping of the structure
  struct Contact {    ///< factors on the parameters of contact points, and what is added to their gaps
    double normal_stiffness = 1;
    std::array<double, 2> tangential_stiffness{1, 1}, friction{1, 1};
    double gap = 0;
  } contact;
};

struct PathParameter {
  const char *name; ///< in the case file
  const char *unit; ///< of its values
  enum class Scale { frequency, none, displacement } scale;
  /// May change the state of preload, and what the contact points are.
  bool changes_joint;
  void (*set)(Setting &, double value); ///< linear in the value
  bool changes_damping = false;
  bool positive() const { return scale != Scale::displacement; } ///< its values must be
};

/// The frequency first: that of a sweep.
extern const std::vector<PathParameter> all_parameters;
inline const PathParameter &frequency_parameter() { return all_parameters[0]; }
/// Its values may be of some contact points only.
inline bool has_points(const PathParameter &parameter) {
  return parameter.changes_joint && parameter.name != std::string("preload");
}
/// Null where there is none of that name.
const PathParameter *parameter_named(const std::string &name);

} // namespace dovetail
