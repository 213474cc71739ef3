#include "preload/varied_preload.hpp"

#include <algorithm>
#include <tuple>

#include "contact/law_traits.hpp"

namespace dovetail {
namespace {

// The law's force at x while the slider is at w, whether it would slip there or not: what motions are measured from.
std::array<double, 3> force_at(const ContactPoint &point, const std::array<double, 3> &x, const Memory &w) {
  std::array<double, 3> force{};
  const double closing = x[2] - point.gap;
  force[2] = !may_open(point.law) ? point.kn * closing : pressed(point.kn, closing);
  for (int d = 0; d < 2 && has_friction(point.law); ++d) force[d] = point.kt[d] * (x[d] - w[d]);
  return force;
}

bool same(const Setting &a, const Setting &b) {
  const auto numbers = [](const Setting &s) {
    return std::tie(s.preload, s.contact.normal_stiffness, s.contact.tangential_stiffness, s.contact.friction,
                    s.contact.gap);
  };
  return numbers(a) == numbers(b);
}

ReducedModel joint_of(const ReducedModel &model) { // what the preload needs of it
  ReducedModel joint;
  joint.comm = model.comm, joint.points = model.points, joint.own_points = model.own_points;
  joint.kxx = model.kxx, joint.r = model.r;
  return joint;
}

} // namespace

VariedPreload::VariedPreload(const PreloadedModel &nominal, const std::vector<bool> &varied)
    : model_(joint_of(nominal.reduced)), nominal_(nominal.contact), origin_(nominal.standstill),
      varied_(nominal_.size(), true), contact_(nominal_), standstill_(origin_), constant_(model_.r.size(), 0.0),
      problem_(model_, contact_), x_(model_.r.size()) {
  for (std::size_t p = 0; p < varied_.size() && !varied.empty(); ++p) varied_[p] = varied[model_.own_points.begin + p];
  begin();
  problem_.keep_factors(x_);
}

void VariedPreload::begin() {
  for (std::size_t i = 0; i < x_.size(); ++i) x_[i] = origin_[i / 3].x[i % 3];
}

std::vector<EquivalentMotion> VariedPreload::equivalent(const Setting &setting, const Setting &slope) const {
  std::vector<EquivalentMotion> out(varied_.size());
  for (std::size_t p = 0; p < out.size(); ++p)
    if (varied_[p]) out[p] = {setting.contact, slope.contact};
  return out;
}

bool VariedPreload::solve(const Setting &setting) {
  if (solved_ && same(*solved_, setting)) return true;
  for (std::size_t p = 0; p < nominal_.size(); ++p)
    if (varied_[p]) contact_[p] = changed(nominal_[p], setting.contact);
  // Always the same start: what is found does not depend on where the curve came from.
  begin();
  std::string note;
  solved_.reset(), along_.reset();
  if (!problem_.find(x_, setting.preload, note)) return false;
  solved_ = setting;
  for (std::size_t p = 0; p < contact_.size(); ++p) {
    Standstill &at = standstill_[p];
    at.w = static_force(contact_[p], &x_[3 * p]).w;
    at.force = force_at(contact_[p], at.x, at.w);
    for (int d = 0; d < 3; ++d)
      constant_[3 * p + d] = at.force[d] - origin_[p].force[d] + (setting.preload - 1) * model_.r[3 * p + d];
  }
  return true;
}

const std::vector<Memory> &VariedPreload::memory_slope(const Setting &setting, const Setting &slope) {
  const bool known = solve(setting) && along_ && same(*along_, slope);
  if (known) return slope_;
  slope_ = solved_ ? slope_of_memory(slope) : std::vector<Memory>(contact_.size());
  along_ = slope;
  return slope_;
}

std::vector<Memory> VariedPreload::slope_of_memory(const Setting &slope) {
  std::vector<Memory> memory(contact_.size());
  std::vector<StaticForce> state;
  int moves = 0; // no slider does while all points stick
  for (std::size_t p = 0; p < contact_.size(); ++p) {
    state.push_back(static_force(contact_[p], &x_[3 * p]));
    if (has_friction(contact_[p].law) && state[p].w != Memory{}) moves = 1;
  }
  MPI_Allreduce(MPI_IN_PLACE, &moves, 1, MPI_INT, MPI_MAX, model_.comm);
  const std::vector<EquivalentMotion> equivalents = equivalent(*solved_, slope);
  std::vector<std::array<double, 3>> by_parameter(contact_.size()); // d force at fixed x
  for (std::size_t p = 0; p < contact_.size() && moves; ++p) {
    const double p_n = x_[3 * p + 2] - contact_[p].gap;
    const EquivalentMotion &equivalent = equivalents[p];
    const double motion[] = {equivalent.all[0] * x_[3 * p], equivalent.all[1] * x_[3 * p + 1],
                             equivalent.all[2] * p_n + equivalent.closing};
    for (int d = 0; d < 3; ++d) {
      for (int e = 0; e < 3; ++e) by_parameter[p][d] += state[p].slope[d][e] * motion[e];
      if (d < 2) by_parameter[p][d] += equivalent.friction[d] * state[p].slope[d][2] * p_n;
    }
  }
  if (!moves) return memory;

  std::vector<double> change(x_.size());
  for (std::size_t i = 0; i < change.size(); ++i) change[i] = by_parameter[i / 3][i % 3] + slope.preload * model_.r[i];
  const std::vector<double> moved = problem_.follow(x_, change);
  for (std::size_t p = 0; p < contact_.size(); ++p) // w = x_t - T / k_t
    for (int d = 0; d < 2 && has_friction(contact_[p].law); ++d) {
      double force = by_parameter[p][d];
      for (int e = 0; e < 3; ++e) force += state[p].slope[d][e] * moved[3 * p + e];
      memory[p][d] = moved[3 * p + d] - (force - equivalents[p].all[d] * state[p].force[d]) / contact_[p].kt[d];
    }
  return memory;
}

} // namespace dovetail
