#include "scaling/scaled_model.hpp"

#include <algorithm>
#include <cmath>

namespace dovetail {

namespace {

constexpr double hardly = 1e-3; // of a force: with less, as of a load that symmetry all but cancels, units are far off

// What is driven first: the model, or where it is cyclic the index of harmonic 1.
struct Driven {
  std::vector<double> kaa, mass, stiffness; // (N_a), diagonals (3 own) of M_xx and K_xx
  // By dof, the largest amplitude of a force: courses as they are, so that residuals are relative to it whatever the
  // units of a pattern. A constant load is no measure of a vibration.
  std::vector<double> modal, contact; // (N_a), (3 own)
};

Driven driven_first(const Case &study, const ReducedModel &model) {
  const int h = std::abs(study.wave(model.sectors).index(1));
  const SectorIndex *index = h > 0 ? &model.indices[h - 1] : nullptr;
  Driven out{index ? index->kaa : model.kaa, std::vector<double>(model.own_contact_dofs()),
             std::vector<double>(model.own_contact_dofs()), std::vector<double>(model.modes, 0.0),
             std::vector<double>(model.own_contact_dofs(), 0.0)};
  const auto take = [](std::vector<double> &largest, const auto &values, double weight) {
    for (std::size_t i = 0; i < values.size(); ++i) largest[i] = std::max(largest[i], weight * std::abs(values[i]));
  };
  for (const LoadCourse &load : study.loads) {
    const std::size_t number = model.load(load.pattern);
    const LoadPattern &pattern = model.loads[number];
    double squares = 0;
    for (std::size_t i = 1; i < load.fourier.size(); ++i) squares += load.fourier[i] * load.fourier[i];
    const double weight = std::sqrt(squares);
    if (index)
      take(out.modal, index->loads[number].fa, weight), take(out.contact, index->loads[number].fx, weight);
    else
      take(out.modal, pattern.fa, weight), take(out.contact, pattern.fx, weight);
  }
  for (std::size_t i = 0; i < out.mass.size(); ++i) {
    const std::size_t diagonal = i * model.contact_dofs() + 3 * model.own_points.begin + i;
    out.mass[i] = index ? index->mxx[diagonal].real() : model.mxx[diagonal];
    out.stiffness[i] = index ? index->kxx[diagonal].real() : model.kxx[diagonal];
  }
  return out;
}

} // namespace

double Scales::of(const PathParameter &parameter) const {
  using Scale = PathParameter::Scale;
  return parameter.scale == Scale::frequency ? frequency : parameter.scale == Scale::displacement ? contact : 1;
}

Scales choose_scales(const Case &study, const PreloadedModel &preloaded) {
  if (study.scaling == ScalingKind::none) return {};
  if (study.scaling == ScalingKind::manual) return {study.scale_frequency, study.scale_modal, study.scale_contact};
  const ReducedModel &model = preloaded.reduced;
  const Driven driven = driven_first(study, model);
  // Per own contact dof: the force at work, and the displacement at which friction gives way under the preload.
  double force = 0, slip_limit = 0, stiffness = 0, mass = 0;
  for (std::size_t i = 0; i < model.r.size(); ++i) {
    const ContactPoint &point = preloaded.contact[i / 3];
    force = std::max(force, driven.contact[i]);
    mass = std::max(mass, driven.mass[i]);
    stiffness = std::max({stiffness, std::abs(driven.stiffness[i]), point.kn});
    if (!has_friction(point.law)) continue;
    const double mu = std::max(point.mu[0], point.mu[1]), kt = std::min(point.kt[0], point.kt[1]);
    const double pressed =
        std::max(std::abs(model.r[i]), preloaded.standstill[i / 3].force[2]); // a gap may press as well
    slip_limit = std::max(slip_limit, mu * pressed / kt);
    stiffness = std::max(stiffness, kt);
  }
  double largest[] = {force, slip_limit, stiffness, mass};
  MPI_Allreduce(MPI_IN_PLACE, largest, 4, MPI_DOUBLE, MPI_MAX, model.comm);
  Scales scales;
  scales.frequency = model.modes > 0 ? std::sqrt(driven.kaa[0]) : study.omega_from;
  double modal_force = model.modes > 0 ? driven.modal[0] : 0;
  for (const double fa : driven.modal) // a first mode that the load hardly moves is no measure
    if (modal_force < hardly * fa) modal_force = fa;
  const double w2 = scales.frequency * scales.frequency;
  scales.contact = largest[1] > 0 ? largest[1] : largest[0] > 0 && largest[2] > 0 ? largest[0] / largest[2] : 1;
  // The motion at which x weighs like a. A joint that never slips has a slip limit far beyond it, one that is hardly
  // pressed far below: neither is a measure of the motion then.
  if (modal_force > 0 && largest[3] > 0) {
    const double natural = modal_force / w2 / std::sqrt(largest[3]);
    scales.contact = std::clamp(scales.contact, 1e-3 * natural, natural);
  }
  // without modal force: such that modal and contact accelerations weigh alike
  scales.modal = modal_force > 0 ? modal_force / w2 : largest[0] > 0 ? std::sqrt(scales.contact * largest[0] / w2) : 1;
  return scales;
}

ScaledModel scaled(PreloadedModel model, const Damping &damping, const Scales &scales) {
  const double w0 = scales.frequency, a = scales.modal, b = scales.contact;
  const double stiffness = std::pow(b / (a * w0), 2), force = b / (a * a * w0 * w0);
  const auto multiply = [](auto &values, double factor) {
    for (auto &value : values) value *= factor;
  };
  const auto multiply_left_out = [&](auto &left) {
    multiply(left.squares, 1 / (w0 * w0));
    for (auto &load : left.loads) multiply(load, 1 / (a * w0 * w0));
    multiply(left.coupling, b / a);
  };
  ReducedModel &reduced = model.reduced;
  multiply(reduced.kaa, 1 / (w0 * w0));
  multiply(reduced.mxa, b / a);
  multiply(reduced.mxx, b / a * (b / a));
  multiply(reduced.kxx, stiffness);
  for (LoadPattern &load : reduced.loads) multiply(load.fa, 1 / (a * w0 * w0)), multiply(load.fx, force);
  for (SectorIndex &index : reduced.indices) {
    multiply(index.kaa, 1 / (w0 * w0));
    multiply(index.mxa, b / a);
    multiply(index.mxx, b / a * (b / a));
    multiply(index.kxx, stiffness);
    for (SectorIndex::Load &load : index.loads) multiply(load.fa, 1 / (a * w0 * w0)), multiply(load.fx, force);
    multiply_left_out(index.left_out);
  }
  const auto multiply_blocks = [&](DampingMatrix &matrix, double factor) {
    multiply(matrix.aa, factor);
    multiply(matrix.xa, factor * b / a);
    multiply(matrix.xx, factor * (b / a * (b / a)));
  };
  multiply_blocks(reduced.viscous, 1 / w0), multiply_blocks(reduced.structural, 1 / (w0 * w0));
  multiply(reduced.r, force);
  multiply_left_out(reduced.left_out);
  for (std::size_t p = 0; p < model.contact.size(); ++p) {
    ContactPoint &point = model.contact[p];
    Standstill &at_rest = model.standstill[p];
    point.kn *= stiffness;
    point.gap /= b;
    for (int d = 0; d < 2; ++d) point.kt[d] *= stiffness, at_rest.w[d] /= b;
    for (int d = 0; d < 3; ++d) at_rest.x[d] /= b, at_rest.force[d] *= force;
  }
  Damping dimensionless(damping.stiffness * w0, damping.mass / w0, damping.structural);
  dimensionless.ratios = damping.ratios, dimensionless.of_fixed = damping.of_fixed;
  dimensionless.matrix = damping.matrix, dimensionless.contact = damping.contact;
  dimensionless.of_parts = model.reduced.structural.given;
  return {std::move(model), std::move(dimensionless), scales};
}

ScaledModel scaled(PreloadedModel model, const Case &study, const Scales &scales) {
  ScaledModel out = scaled(std::move(model), study.damping, scales);
  out.highest = std::max(study.omega_from, study.omega_to) / scales.frequency;
  out.engine_order = study.wave(out.model.reduced.sectors).engine_order;
  return out;
}

} // namespace dovetail
