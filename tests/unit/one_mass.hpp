#pragma once
// One mass of 1 on one contact point, on springs of its own, on any number of ranks.
#include <array>
#include <vector>

#include "harmonic/harmonic_system.hpp"
#include "preload/contact_preload.hpp"

namespace dovetail::testing {

/// springs, steady and moving forces: along t1, t2, n. Contact forces exactly.
inline HarmonicSystem one_mass(std::array<double, 3> springs, std::array<double, 3> steady,
                               std::array<double, 3> moving, const ContactPoint &point, double damping, int harmonics,
                               std::vector<double> fourier = {0, 1}) {
  ReducedModel model;
  model.comm = PETSC_COMM_WORLD;
  model.points = 1;
  model.own_points = own_share(model.comm, 1), model.own_modes = own_share(model.comm, 0);
  std::vector<ContactPoint> contact;
  std::vector<double> initial;
  if (model.own_points.size() == 1) {
    model.kxx = {springs[0], 0, 0, 0, springs[1], 0, 0, 0, springs[2]}, model.mxx = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    model.r = {steady.begin(), steady.end()}, model.loads[0].fx = {moving.begin(), moving.end()};
    contact = {point}, initial = {0, 0, 0};
  }
  std::string note;
  return HarmonicSystem(scaled(contact_preload(std::move(model), std::move(contact), initial, note), damping, {}),
                        harmonics, exactly, {{force_pattern, std::move(fourier), ""}});
}

} // namespace dovetail::testing
