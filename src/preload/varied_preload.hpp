#pragma once
// The state of preload while the joint's parameters, or the preload itself, change: what a path over them stands on.
#include <optional>
#include <vector>

#include "contact/contact_change.hpp"
#include "preload/contact_preload.hpp"
#include "preload/preload_problem.hpp"

namespace dovetail {

class VariedPreload {
public:
  /// `nominal`: with its K_xx; the factors of settings refer to it. `varied`: (N_x) the points whose parameters they
  /// are; empty: all. Collective.
  explicit VariedPreload(const PreloadedModel &nominal, const std::vector<bool> &varied = {});

  /// The own contact points at a setting, and what motions measured from the nominal state are to stand on: x_p is
  /// the nominal one, w_p of the setting; `force` is what the law has there. False where no state of preload is found.
  /// Collective.
  bool solve(const Setting &setting);
  const std::vector<ContactPoint> &contact() const { return contact_; }
  const std::vector<Standstill> &standstill() const { return standstill_; }
  /// (3 own) force that is left in the equations by measuring from there: standstill forces and preload now, less then.
  const std::vector<double> &constant() const { return constant_; }
  /// (own) what changes the forces of the points as that slope does.
  std::vector<EquivalentMotion> equivalent(const Setting &setting, const Setting &slope) const;
  /// d w_p along a slope, at a setting that has a state of preload. Collective.
  const std::vector<Memory> &memory_slope(const Setting &setting, const Setting &slope);

private:
  void begin();                                              // at the nominal state
  std::vector<Memory> slope_of_memory(const Setting &slope); // at the state that was solved for
  ReducedModel model_;                                       // K_xx and R
  const std::vector<ContactPoint> nominal_;
  const std::vector<Standstill> origin_;
  std::vector<bool> varied_; // (own)
  std::vector<ContactPoint> contact_;
  std::vector<Standstill> standstill_;
  std::vector<double> constant_;
  PreloadProblem problem_;
  std::vector<double> x_; // (3 own) x_p at the setting
  std::optional<Setting> solved_;
  std::optional<Setting> along_; // the slope of `slope_` there
  std::vector<Memory> slope_;
};

} // namespace dovetail
