#include "case/keys.hpp"

#include <algorithm>

#include "case/case.hpp"
#include "case/contact_settings.hpp"
#include "case/number_text.hpp"
#include "contact/law_traits.hpp"

namespace dovetail {
namespace {

std::string numbers_text(const std::vector<double> &values) {
  std::string result;
  for (const double value : values) result += (result.empty() ? "[" : ", ") + number_text(value);
  return result.empty() ? result : result + "]";
}

std::string frequencies_text(const Case &study, const std::vector<double> &omegas) {
  std::string result;
  for (const double omega : omegas) result += (result.empty() ? "[" : ", ") + study.frequency_unit.number(omega);
  return result.empty() ? result : result + "]";
}

std::string fourier_text(std::vector<double> values) {
  while (values.size() > 1 && values.back() == 0) values.pop_back(); // padded to 2H+1 by the parser
  return numbers_text(values);
}

std::string loads_text(const std::vector<LoadCourse> &loads) {
  std::string result;
  for (const LoadCourse &load : loads)
    result += (result.empty() ? "" : ", ") + load.pattern + " " + fourier_text(load.fourier);
  return result;
}

std::string ratios_text(const std::vector<ModeRatio> &ratios) {
  std::string result;
  for (const auto &[mode, ratio] : ratios)
    result += (result.empty() ? "[[" : ", [") + std::to_string(mode) + ", " + number_text(ratio) + "]";
  return result.empty() ? "none" : result + "]";
}

std::string spread_text(const std::vector<double> &values) {
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  return number_text(*low) + (*low == *high ? "" : " .. " + number_text(*high));
}

std::string per_area_text(const std::optional<ContactSetting> &setting) {
  return setting && setting->per_area ? spread_text(setting->values) : "";
}

std::string manual(const Case &study, double value) {
  return study.scaling == ScalingKind::manual ? number_text(value) : "";
}

std::string motion_text(const MotionWish &wish) {
  if (!wish.given) return "all if little";
  if (wish.all) return "all";
  std::string result;
  for (const auto &set : wish.sets) result += (result.empty() ? "" : ", ") + set;
  for (const long node : wish.nodes) result += (result.empty() ? "" : ", ") + std::to_string(node);
  return result.empty() ? "none" : result;
}

std::string samples_text(const Case &study) {
  if (study.samples != exactly) return std::to_string(study.samples);
  const bool cone = study.contact.law.any(shares_slider);
  return cone ? "exact; cone: " + std::to_string(enough_samples(study.harmonics)) : "exact";
}

std::string solver_text(SolverKind kind) { return kind == SolverKind::modal ? "modal" : "assembled"; }

std::string kind_text(ScalingKind kind) {
  return kind == ScalingKind::automatic ? "auto" : kind == ScalingKind::none ? "none" : "manual";
}

std::vector<std::string> parameter_names() {
  std::vector<std::string> names;
  for (const PathParameter &parameter : all_parameters)
    if (&parameter != &frequency_parameter()) names.push_back(parameter.name);
  return names;
}

std::vector<std::string> strategy_names() {
  std::vector<std::string> names;
  for (const Strategy &one : all_strategies) names.push_back(one.name);
  return names;
}

constexpr int most_order = 1000000; // of engines

} // namespace

bool Key::has_standard_value() const {
  const std::string word = standard;
  return word == "true" || word == "false" || std::string("-0123456789\"[").find(word[0]) != std::string::npos;
}

const Key *key_named(const std::string &name) {
  for (const Key &key : keys())
    if (key.name == name) return &key;
  return nullptr;
}

const std::vector<Key> &keys() {
  using C = const Case &;
  using Shape = Value::Shape;
  static const std::vector<Key> table = {
      {"title", "", text(), "none", "shown in messages and pictures", [](C c) { return c.title; }},
      {"model", "", text(), "required", "the full model, an HDF5 file; or give reduced",
       [](C c) { return c.model.string(); }},
      {"reduced", "", text(), "required", "a reduced model, used as it stands, in place of model",
       [](C c) { return c.reduced.string(); }},
      {"reduction.modes", "-", whole(0), "required",
       "N_a, vibration modes kept with the contact points held; without it accuracy.tolerance chooses them",
       [](C c) { return c.model.empty() ? "" : std::to_string(c.modes); }},
      {"reduction.kind", "", word({"craig-bampton", "residual"}), "\"craig-bampton\"",
       "residual: half of the modes are made of what moving contacts and the load ask of all others",
       [](C c) { return c.model.empty() ? "" : std::string(c.residuals ? "residual" : "craig-bampton"); }},
      {"reduction.interior_modes", "-", whole(1), "five times reduction.modes",
       "of a cyclic sector: how many modes all nodal diameters share",
       [](C c) { return c.interior_modes > 0 ? std::to_string(c.interior_modes) : std::string(); }},
      {"reduction.exact_modes", "", truth(), "false", "of a cyclic sector: modes that do not depend on interior_modes",
       [](C c) { return std::string(c.exact_modes ? "true" : ""); }},
      {"reduction.check_modes", "", truth(), "false",
       "count the modes below the last one, to be sure that none was missed",
       [](C c) { return c.model.empty() ? "" : std::string(c.check_modes ? "true" : "false"); }},
      {"reduction.memory", "GiB", positive(), "what is free", "what the reduction may take on one machine",
       [](C c) { return c.model.empty() ? ""
                        : c.memory > 0  ? number_text(c.memory)
                                        : "what is free"; }},
      {"damping.stiffness", "s", not_negative(), "0", "b of viscous damping b K; the damping ratio is b omega / 2",
       [](C c) { return number_text(c.damping.stiffness); }},
      {"damping.mass", "1/s", not_negative(), "0", "a of viscous damping a M; the damping ratio is a / (2 omega)",
       [](C c) { return number_text(c.damping.mass); }},
      {"damping.structural", "-", not_negative(), "0",
       "eta of hysteretic damping i eta K; the damping ratio is eta / 2",
       [](C c) { return number_text(c.damping.structural); }},
      {"damping.ratios", "-", not_negative(1).as(Shape::ratios), "none",
       "damping ratios of single modes, [[mode, ratio], ...], besides the others",
       [](C c) { return ratios_text(c.damping.ratios); }},
      {"damping.of", "", word({"stuck", "fixed"}), "\"stuck\"",
       "whose modes these are: of the joint stuck, or with all contact dofs held",
       [](C c) {
         return std::string(c.damping.ratios.empty() ? "" : c.damping.of_fixed ? "fixed" : "stuck");
       }},
      {"damping.matrix", "", truth(), "false", "the viscous matrix /C of the model, too",
       [](C c) { return std::string(c.damping.matrix ? "true" : "false"); }},
      {"damping.contact", "", truth(), "false",
       "stiffness also takes the springs of contacts that stick at the preload state",
       [](C c) { return std::string(c.damping.contact ? "true" : "false"); }},
      {"excitation.fourier", "-", number().as(Shape::list), "required",
       "f(t) as [a0, a1, b1, a2, b2, ...], times /force of the model; or give excitation.load",
       [](C c) { return c.given.count("excitation.load") ? std::string() : fourier_text(c.loads[0].fourier); }},
      {"excitation.load", "-", tables(), "none",
       "in place of fourier: load patterns of the model, each with its own course",
       [](C c) { return c.given.count("excitation.load") ? loads_text(c.loads) : ""; }},
      {"excitation.engine_order", "-", whole(-most_order, most_order), "required for a cyclic sector",
       "sector j of N feels the load j engine_order / N of the period later",
       [](C c) { return c.engine_order ? std::to_string(*c.engine_order) : std::string(); }},
      {"excitation.load.pattern", "", text(), "required", "a name in /forces of the model, or force", nullptr},
      {"excitation.load.fourier", "-", number().as(Shape::list), "required", "its course, [a0, a1, b1, a2, b2, ...]",
       nullptr},
      {"contact.law", "", word(law_words()).as(Shape::one_or_list), "\"coulomb\"", "the contact law", nullptr},
      {"contact.normal_stiffness", "N/m", positive().as(Shape::one_or_list), "from the model file", "k_n", nullptr},
      {"contact.tangential_stiffness", "N/m", positive().as(Shape::one_or_pairs), "from the model file",
       "k_t: a number, a pair [t1, t2], or one such pair per point", nullptr},
      {"contact.normal_stiffness_per_area", "N/m^3", positive().as(Shape::one_or_list), "none",
       "in place of normal_stiffness: times the area of each point",
       [](C c) { return per_area_text(c.contact.normal_stiffness); }},
      {"contact.tangential_stiffness_per_area", "N/m^3", positive().as(Shape::one_or_pairs), "none",
       "in place of tangential_stiffness: times the area of each point",
       [](C c) { return per_area_text(c.contact.tangential_stiffness); }},
      {"contact.friction", "-", not_negative().as(Shape::one_or_pairs), "from the model file",
       "mu: a number, a pair [t1, t2], or one such pair per point", nullptr},
      {"contact.gap", "m", number().as(Shape::one_or_list), "from the model file, or 0",
       "normal displacement at which the contact lifts off; positive: a clearance", nullptr},
      {"preload.initial", "m", number().as(Shape::one_or_list), "0",
       "where the search for the preload state starts: a number, or one per contact dof",
       [](C c) { return spread_text(c.preload_initial); }},
      {"accuracy.tolerance", "-", positive(1), "none", "largest error of a point; harmonics and modes are then chosen",
       [](C c) { return c.tolerance > 0 ? number_text(c.tolerance) : std::string("none"); }},
      {"accuracy.estimates", "", truth(), "true", "estimate the error of every point",
       [](C c) { return std::string(c.estimates ? "true" : "false"); }},
      {"accuracy.between", "-", positive(1), "accuracy.tolerance, or 1e-3",
       "by how much the curve drawn between two points may miss the computed one, relative",
       [](C c) { return number_text(c.between); }},
      {"harmonic_balance.harmonics", "-", whole(1, 1000), "required",
       "H; 3 to 9 for friction, more where contacts open; without it accuracy.tolerance chooses them",
       [](C c) { return std::to_string(c.harmonics) + (c.tolerance > 0 ? ", then by tolerance" : ""); }},
      {"harmonic_balance.samples", "-", whole(3, 1 << 20).or_word("exact"), "\"exact\"",
       "instants of the period at which contact forces are evaluated, at least 2H+1; exact: from event to event",
       [](C c) { return samples_text(c); }},
      {"harmonic_balance.solver", "", word({"modal", "assembled"}), "\"modal\"",
       "in modes of the stuck structure, or one sparse matrix", [](C c) { return solver_text(c.solver); }},
      {"newton.step_tolerance", "-", positive(1), "1e-8", "largest last step, relative to the unknowns",
       [](C c) { return number_text(c.step_tolerance); }},
      {"newton.residual_tolerance", "-", positive(1), "1e-8",
       "largest residual, in scaled variables, unless rounding leaves more",
       [](C c) { return number_text(c.residual_tolerance); }},
      {"newton.max_iterations", "-", whole(1), "20", "beyond it the step along the curve is cut",
       [](C c) { return std::to_string(c.max_iterations); }},
      {"scaling.kind", "", word({"auto", "none", "manual"}), "\"auto\"",
       "of variables inside the solver; manual: by the three numbers below", [](C c) { return kind_text(c.scaling); }},
      {"scaling.frequency", "rad/s", positive(), "none", "w0, for manual only",
       [](C c) { return manual(c, c.scale_frequency); }},
      {"scaling.modal", "m kg^1/2", positive(), "none", "alpha, the size of the modal unknowns, for manual only",
       [](C c) { return manual(c, c.scale_modal); }},
      {"scaling.contact", "m", positive(), "none", "beta, the size of the contact displacements, for manual only",
       [](C c) { return manual(c, c.scale_contact); }},
      {"continuation.unit", "", word({"rad/s", "Hz"}), "\"rad/s\"", "of omega and at here, of path.omega and mode.near",
       [](C c) { return std::string(c.frequency_unit.name()); }},
      {"continuation.omega", "rad/s", positive().as(Shape::pair), "required",
       "the sweep, [from, to], in either direction; equal: one point; not with [path] or [mode]",
       [](C c) {
         return c.range().is_sweep() || c.follows_peaks() ? frequencies_text(c, {c.omega_from, c.omega_to}) : "";
       }},
      {"continuation.step", "-", positive(), "0.02", "first arc length; 1: the whole sweep, or the largest motion",
       [](C c) { return number_text(c.step); }},
      {"continuation.adaptive", "", truth(), "true", "false: keep that arc length throughout, in scaled variables",
       [](C c) { return std::string(c.adaptive ? "true" : "false"); }},
      {"continuation.max_points", "-", whole(1), "20000", "the run ends there",
       [](C c) { return std::to_string(c.max_points); }},
      {"continuation.at", "rad/s", number().as(Shape::list), "none",
       "frequencies wanted exactly, in the order of the sweep",
       [](C c) { return c.range().is_sweep() ? frequencies_text(c, c.at) : ""; }},
      {"continuation.start", "", text(), "from rest",
       "results of another run: begin at its point nearest to the first frequency",
       [](C c) { return c.start.empty() ? "zero" : c.start.string(); }},
      {"continuation.watch", "", text(), "the contact dof that moves most",
       "whose amplitude is followed: \"tip.y\" of a node, \"x3.n\" of a contact point, \"a1\" of a mode",
       [](C c) { return c.watch.name.empty() ? "what moves most" : c.watch.name; }},
      {"continuation.stop_after_peaks", "-", whole(1), "never", "end the run after so many maxima of that amplitude",
       [](C c) { return c.stop_after_peaks ? std::to_string(c.stop_after_peaks) : std::string("never"); }},
      {"continuation.stop_at_amplitude", "m", positive(), "never",
       "end the run where that amplitude reaches this value",
       [](C c) { return c.stop_at_amplitude > 0 ? number_text(c.stop_at_amplitude) : std::string("never"); }},
      {"path.parameter", "", word(parameter_names()), "required", "what is varied",
       [](C c) { return std::string(c.path ? c.path->parameter->name : ""); }},
      {"path.joint", "", text(), "all", "name of a joint: only its contact points are varied",
       [](C c) { return std::string(c.path ? c.path->joint : ""); }},
      {"path.points", "", whole(1).as(Shape::list), "all", "in place of joint: numbers of contact points, from 1",
       [](C c) {
         return c.path ? numbers_text({c.path->points.begin(), c.path->points.end()}) : "";
       }},
      {"path.range", "-", number().as(Shape::pair), "required",
       "[from, to], factors on what the case has; of the gap: what is added to it",
       [](C c) {
         return c.path ? numbers_text({c.path->from, c.path->to}) : "";
       }},
      {"path.omega", "rad/s", positive(), "required", "the frequency; or give path.peak",
       [](C c) { return c.path && !c.path->peak ? c.frequency_unit.number(c.omega_from) : ""; }},
      {"path.peak", "", word({"amplitude", "phase"}), "none",
       "follow the peak of continuation.watch, or phase resonance",
       [](C c) {
         return std::string(!c.follows_peaks() ? "" : *c.path->peak == PeakKind::phase ? "phase" : "amplitude");
       }},
      {"path.at", "-", number().as(Shape::list), "none", "values wanted exactly, in the order of the range",
       [](C c) { return c.path ? numbers_text(c.at) : ""; }},
      {"mode.number", "-", whole(1), "required", "number of the mode of the stuck structure, from 1; or give mode.near",
       [](C c) { return c.mode && c.mode->number > 0 ? std::to_string(c.mode->number) : ""; }},
      {"mode.near", "rad/s", positive(), "none", "a frequency: the mode nearest to it",
       [](C c) { return c.mode && c.mode->near > 0 ? c.frequency_unit.number(c.mode->near) : ""; }},
      {"mode.amplitude", "m kg^1/2", positive().as(Shape::pair), "required", "[from, to], rising: modal amplitudes",
       [](C c) {
         return c.mode ? numbers_text({c.mode->from, c.mode->to}) : "";
       }},
      {"mode.at", "m kg^1/2", number().as(Shape::list), "none", "amplitudes wanted exactly, rising",
       [](C c) { return c.mode ? numbers_text(c.at) : ""; }},
      {"mode.to_force", "-", positive(), "never",
       "end the mode where it is the resonance under this multiple of the load",
       [](C c) { return c.mode && c.mode->to_force > 0 ? number_text(c.mode->to_force) : ""; }},
      {"sensitivity.of", "", text(), "none",
       "an unknown such as \"x4.t1\": derivatives of its peaks by all contact parameters",
       [](C c) { return c.sensitivity ? c.watch.name : ""; }},
      {"recovery.strategies", "", word(strategy_names()).as(Shape::list), "all",
       "what is tried where the curve does not go on; []: nothing", [](C c) { return c.strategies.text(); }},
      {"recovery.allow_branch_change", "", truth(), "true",
       "false: nothing after which the curve may be another branch",
       [](C c) { return std::string(c.allow_branch_change ? "true" : "false"); }},
      {"recovery.work", "", positive(), "1", "what time integration may take for recovery, so many times the default",
       [](C c) { return number_text(c.work); }},
      {"stability.enabled", "", truth(), "true for small models", "judge every point: stable, unstable or uncertain",
       [](C c) {
         return std::string(!c.stability ? "true for small models" : *c.stability ? "true" : "false");
       }},
      {"output.directory", "", text(), "beside the case file", "for results.h5, reduced.h5, summary.json",
       [](C c) { return c.directory.string(); }},
      {"output.motion", "", node().as(Shape::list).or_word("all"), "all while that is little",
       "whose motion can be computed later: node sets and nodes; []: none",
       [](C c) { return c.model.empty() ? "" : motion_text(c.motion); }},
  };
  return table;
}

} // namespace dovetail
