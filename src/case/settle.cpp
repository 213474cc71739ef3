// What a case leaves open until the size of the model is known.
#include <algorithm>

#include "case/case.hpp"
#include "case/undamped.hpp"
#include "contact/law_traits.hpp"
#include "support/error.hpp"

namespace dovetail {
namespace {

// Friction that no varied point has by its law is refused after this, in other words.
void refuse_factor_on_nothing(const Case &study, const std::vector<ContactPoint> &points) {
  const Path &path = *study.path;
  const std::string name = path.parameter->name,
                    place = study.given.at("path.parameter") + ": path.parameter = \"" + name + "\": ";
  if (path.parameter->changes_damping && undamped(study.damping))
    throw InputError(place + "the case has no damping, so a factor on it changes nothing; write some under [damping]");
  if (name.rfind("friction", 0) != 0) return;
  bool rubs = false, some = false;
  for (std::size_t p = 0; p < points.size(); ++p) {
    if (!(path.varied.empty() || path.varied[p]) || !has_friction(points[p].law)) continue;
    rubs = true;
    some = some || (name != "friction_2" && points[p].mu[0] > 0) || (name != "friction_1" && points[p].mu[1] > 0);
  }
  if (rubs && !some)
    throw InputError(place + (path.varied.empty() ? "all" : "all of its") +
                     " contact points have a contact.friction of 0 there, so a factor on it changes nothing");
}

} // namespace

int watched_dof(const Case &study, int modes, int points) {
  const Watch &watch = study.watch;
  if (watch.name.empty() || !watch.node.empty()) return -1;
  const bool mode = watch.direction < 0;
  if (watch.number > (mode ? modes : points))
    throw InputError(watch.where + " = \"" + watch.name + "\": the model has " +
                     (mode ? std::to_string(modes) + " modes" : std::to_string(points) + " contact points"));
  return mode ? watch.number - 1 : modes + 3 * (watch.number - 1) + watch.direction;
}

void settle_units(Case &study, const Units &units) {
  FrequencyUnit &unit = study.frequency_unit;
  study.units = units;
  unit.seconds = units.seconds, unit.omega = units.omega;
  if (!unit.hertz) return;
  study.omega_from *= units.seconds, study.omega_to *= units.seconds;
  if (study.mode) study.mode->near *= units.seconds;
  for (std::size_t i = 0; i < study.at.size() && study.range().is_sweep(); ++i) study.at[i] *= units.seconds;
}

void settle_path(Case &study, const ContactSettings &from_model, int points) {
  if (!study.path || (study.path->joint.empty() && study.path->points.empty())) return;
  Path &path = *study.path;
  const bool by_name = !path.joint.empty();
  const std::string key = by_name ? "path.joint" : "path.points", place = study.given.at(key) + ": " + key + " = ";
  path.varied.assign(points, false);
  for (const int point : path.points) {
    if (point > points)
      throw InputError(place + std::to_string(point) + ": the model has " + std::to_string(points) +
                       " contact points, numbered from 1");
    path.varied[point - 1] = true;
  }
  if (!by_name) return;
  const std::vector<std::string> &names = from_model.joints;
  const auto found = std::find(names.begin(), names.end(), path.joint);
  if (names.empty() || int(from_model.joint.size()) != points)
    throw InputError(
        place + '"' + path.joint + "\": " + (study.reduced.empty() ? study.model : study.reduced).string() +
        " does not say which joint a contact point is of; write path.points = [...], their numbers from 1");
  if (found == names.end()) {
    std::string list;
    for (const std::string &name : names) list += (list.empty() ? "\"" : ", \"") + name + '"';
    throw InputError(place + '"' + path.joint + "\": there is no such joint; " + study.model.string() + " has " + list);
  }
  for (int p = 0; p < points; ++p) path.varied[p] = from_model.joint[p] == found - names.begin();
}

void check_path(const Case &study, const std::vector<ContactPoint> &points) {
  if (study.follows_peaks() &&
      std::any_of(points.begin(), points.end(), [](const ContactPoint &p) { return p.law == Law::cone; }))
    throw InputError(study.given.at("path.peak") + ": path.peak: wants exact contact forces, and points of law cone "
                                                   "have none; write another contact.law, or path.omega");
  const bool changes_joint = study.path && study.path->parameter->changes_joint;
  if (changes_joint || study.sensitivity) { // such damping is made of the joint once
    const std::string key = study.path ? "path.parameter" : "sensitivity.of", place = study.given.at(key) + ": " + key;
    if (study.damping.depends_on_joint())
      throw InputError(place + ": damping." + (study.damping.has_stuck_ratios() ? "ratios" : "contact") +
                       " is made of the joint as the case has it, and would not change with it; write damping.of = "
                       "\"fixed\", or another damping");
  }
  if (study.path) refuse_factor_on_nothing(study, points);
  if (!changes_joint) return;
  const std::string name = study.path->parameter->name,
                    place = study.given.at("path.parameter") + ": path.parameter = \"" + name + "\": ";
  const std::vector<bool> &varied = study.path->varied;
  const auto any = [&](auto &&wanted) {
    for (std::size_t p = 0; p < points.size(); ++p)
      if ((varied.empty() || varied[p]) && wanted(points[p])) return true;
    return false;
  };
  if (points.empty()) throw InputError(place + "the model has no contact points");
  const bool rubs = any([](const ContactPoint &p) { return has_friction(p.law); }),
             about_friction = name.rfind("friction", 0) == 0 || name.rfind("tangential", 0) == 0;
  if (about_friction && !rubs)
    throw InputError(place + (varied.empty() ? "no contact point" : "none of its contact points") +
                     " has friction, by contact.law");
  if ((name == "friction_1" || name == "friction_2") && any([](const ContactPoint &p) { return shares_slider(p.law); }))
    throw InputError(place + "points of law cone have one friction for both directions; write \"friction\"");
}

void check_damping(const Case &study, int modes, int points, bool has_matrix) {
  const bool fixed = study.damping.of_fixed;
  const int most = fixed ? modes : modes + 3 * points;
  for (const ModeRatio &ratio : study.damping.ratios)
    if (ratio.mode > most)
      throw InputError(study.ratios_where + ": mode " + std::to_string(ratio.mode) + ": the reduced model has " +
                       std::to_string(most) + (fixed ? " fixed-interface modes, N_a" : " modes, N_a + 3 N_x"));
  if (study.damping.matrix && !has_matrix)
    throw InputError(study.given.at("damping.matrix") + ": damping.matrix = true: " +
                     (study.reduced.empty()
                          ? study.model.string() + " has no /C; write the viscous damping matrix there"
                          : study.reduced.string() + " has no /Caa; write the viscous damping matrix "
                                                     "as /Caa, /Cax and /Cxx there") +
                     ", or leave damping.matrix out");
}

void settle_solver(Case &study, int dofs) {
  constexpr double most_assembled = 500; // unknowns
  if (!study.mode || study.given.count("harmonic_balance.solver")) return;
  const bool small = double(dofs) * (2 * study.harmonics + 1) <= most_assembled;
  study.solver = small ? SolverKind::assembled : SolverKind::modal;
}

// Where judging a point takes hardly more time than computing it. (Measured: five dofs, one point, H = 10: 0.03 ms
// where nothing slips, 0.2 ms where it does, 1.5 ms with Hill's method, to some 1 ms for the point; 15 dofs, 4 points,
// H = 5: 0.2, 1 and 7 ms to 3.3 ms; 18 dofs, 5 points, H = 7: 20 ms to 8 ms.)
void settle_stability(Case &study, int dofs) {
  constexpr double small = 150; // unknowns
  if (!study.stability) study.stability = double(dofs) * (2 * study.harmonics + 1) <= small;
}

} // namespace dovetail
