#include "case/keys.hpp"

#include <algorithm>

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

} // namespace

const std::vector<Key> &keys() {
  using C = const Case &;
  static const std::vector<Key> table = {
      {"title", "", [](C c) { return c.title; }},
      {"model", "", [](C c) { return c.model.string(); }},
      {"reduced", "", [](C c) { return c.reduced.string(); }},
      {"reduction.modes", "-", [](C c) { return c.model.empty() ? "" : std::to_string(c.modes); }},
      {"reduction.kind", "",
       [](C c) { return c.model.empty() ? "" : std::string(c.residuals ? "residual" : "craig-bampton"); }},
      {"reduction.interior_modes", "-",
       [](C c) { return c.interior_modes > 0 ? std::to_string(c.interior_modes) : std::string(); }},
      {"reduction.exact_modes", "", [](C c) { return std::string(c.exact_modes ? "true" : ""); }},
      {"reduction.check_modes", "",
       [](C c) { return c.model.empty() ? "" : std::string(c.check_modes ? "true" : "false"); }},
      {"reduction.memory", "GiB",
       [](C c) { return c.model.empty() ? ""
                        : c.memory > 0  ? number_text(c.memory)
                                        : "what is free"; }},
      {"damping.stiffness", "s", [](C c) { return number_text(c.damping.stiffness); }},
      {"damping.mass", "1/s", [](C c) { return number_text(c.damping.mass); }},
      {"damping.structural", "-", [](C c) { return number_text(c.damping.structural); }},
      {"damping.ratios", "-", [](C c) { return ratios_text(c.damping.ratios); }},
      {"damping.of", "",
       [](C c) {
         return std::string(c.damping.ratios.empty() ? "" : c.damping.of_fixed ? "fixed" : "stuck");
       }},
      {"damping.matrix", "", [](C c) { return std::string(c.damping.matrix ? "true" : "false"); }},
      {"damping.contact", "", [](C c) { return std::string(c.damping.contact ? "true" : "false"); }},
      {"excitation.fourier", "-",
       [](C c) { return c.given.count("excitation.load") ? std::string() : fourier_text(c.loads[0].fourier); }},
      {"excitation.load", "-", [](C c) { return c.given.count("excitation.load") ? loads_text(c.loads) : ""; }},
      {"excitation.engine_order", "-",
       [](C c) { return c.engine_order ? std::to_string(*c.engine_order) : std::string(); }},
      {"excitation.load.pattern", "", nullptr},
      {"excitation.load.fourier", "-", nullptr},
      {"contact.law", "", nullptr},
      {"contact.normal_stiffness", "N/m", nullptr},
      {"contact.tangential_stiffness", "N/m", nullptr},
      {"contact.normal_stiffness_per_area", "N/m^3", [](C c) { return per_area_text(c.contact.normal_stiffness); }},
      {"contact.tangential_stiffness_per_area", "N/m^3",
       [](C c) { return per_area_text(c.contact.tangential_stiffness); }},
      {"contact.friction", "-", nullptr},
      {"contact.gap", "m", nullptr},
      {"preload.initial", "m", [](C c) { return spread_text(c.preload_initial); }},
      {"accuracy.tolerance", "-", [](C c) { return c.tolerance > 0 ? number_text(c.tolerance) : std::string("none"); }},
      {"accuracy.estimates", "", [](C c) { return std::string(c.estimates ? "true" : "false"); }},
      {"accuracy.between", "-", [](C c) { return number_text(c.between); }},
      {"harmonic_balance.harmonics", "-",
       [](C c) { return std::to_string(c.harmonics) + (c.tolerance > 0 ? ", then by tolerance" : ""); }},
      {"harmonic_balance.samples", "-", [](C c) { return samples_text(c); }},
      {"harmonic_balance.solver", "", [](C c) { return solver_text(c.solver); }},
      {"newton.step_tolerance", "-", [](C c) { return number_text(c.step_tolerance); }},
      {"newton.residual_tolerance", "-", [](C c) { return number_text(c.residual_tolerance); }},
      {"newton.max_iterations", "-", [](C c) { return std::to_string(c.max_iterations); }},
      {"scaling.kind", "", [](C c) { return kind_text(c.scaling); }},
      {"scaling.frequency", "rad/s", [](C c) { return manual(c, c.scale_frequency); }},
      {"scaling.modal", "m kg^1/2", [](C c) { return manual(c, c.scale_modal); }},
      {"scaling.contact", "m", [](C c) { return manual(c, c.scale_contact); }},
      {"continuation.unit", "", [](C c) { return std::string(c.frequency_unit.name()); }},
      {"continuation.omega", "rad/s",
       [](C c) {
         return c.range().is_sweep() || c.follows_peaks() ? frequencies_text(c, {c.omega_from, c.omega_to}) : "";
       }},
      {"continuation.step", "-", [](C c) { return number_text(c.step); }},
      {"continuation.adaptive", "", [](C c) { return std::string(c.adaptive ? "true" : "false"); }},
      {"continuation.max_points", "-", [](C c) { return std::to_string(c.max_points); }},
      {"continuation.at", "rad/s", [](C c) { return c.range().is_sweep() ? frequencies_text(c, c.at) : ""; }},
      {"continuation.start", "", [](C c) { return c.start.empty() ? "zero" : c.start.string(); }},
      {"continuation.watch", "", [](C c) { return c.watch.name.empty() ? "what moves most" : c.watch.name; }},
      {"continuation.stop_after_peaks", "-",
       [](C c) { return c.stop_after_peaks ? std::to_string(c.stop_after_peaks) : std::string("never"); }},
      {"continuation.stop_at_amplitude", "m",
       [](C c) { return c.stop_at_amplitude > 0 ? number_text(c.stop_at_amplitude) : std::string("never"); }},
      {"path.parameter", "", [](C c) { return std::string(c.path ? c.path->parameter->name : ""); }},
      {"path.joint", "", [](C c) { return std::string(c.path ? c.path->joint : ""); }},
      {"path.points", "",
       [](C c) {
         return c.path ? numbers_text({c.path->points.begin(), c.path->points.end()}) : "";
       }},
      {"path.range", "-",
       [](C c) {
         return c.path ? numbers_text({c.path->from, c.path->to}) : "";
       }},
      {"path.omega", "rad/s", [](C c) { return c.path && !c.path->peak ? c.frequency_unit.number(c.omega_from) : ""; }},
      {"path.peak", "",
       [](C c) {
         return std::string(!c.follows_peaks() ? "" : *c.path->peak == PeakKind::phase ? "phase" : "amplitude");
       }},
      {"path.at", "-", [](C c) { return c.path ? numbers_text(c.at) : ""; }},
      {"mode.number", "-", [](C c) { return c.mode && c.mode->number > 0 ? std::to_string(c.mode->number) : ""; }},
      {"mode.near", "rad/s",
       [](C c) { return c.mode && c.mode->near > 0 ? c.frequency_unit.number(c.mode->near) : ""; }},
      {"mode.amplitude", "m kg^1/2",
       [](C c) {
         return c.mode ? numbers_text({c.mode->from, c.mode->to}) : "";
       }},
      {"mode.at", "m kg^1/2", [](C c) { return c.mode ? numbers_text(c.at) : ""; }},
      {"mode.to_force", "-", [](C c) { return c.mode && c.mode->to_force > 0 ? number_text(c.mode->to_force) : ""; }},
      {"sensitivity.of", "", [](C c) { return c.sensitivity ? c.watch.name : ""; }},
      {"recovery.strategies", "", [](C c) { return c.strategies.text(); }},
      {"recovery.allow_branch_change", "", [](C c) { return std::string(c.allow_branch_change ? "true" : "false"); }},
      {"recovery.work", "", [](C c) { return number_text(c.work); }},
      {"stability.enabled", "",
       [](C c) {
         return std::string(!c.stability ? "true for small models" : *c.stability ? "true" : "false");
       }},
      {"output.directory", "", [](C c) { return c.directory.string(); }},
      {"output.motion", "", [](C c) { return c.model.empty() ? "" : motion_text(c.motion); }},
  };
  return table;
}

} // namespace dovetail
