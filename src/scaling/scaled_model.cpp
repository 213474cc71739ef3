#include "scaling/scaled_model.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <string>

#include "support/error.hpp"

namespace dovetail {

namespace {

constexpr double hardly = 1e-3; // of a force: with less, as of a load that symmetry all but cancels, units are far off

// What is driven first: the model, or where it is cyclic the index of harmonic 1.
struct Driven {
  std::vector<double> kaa, mass, stiffness; // (N_a), diagonals (3 own) of M_xx and K_xx
  // Amplitudes of the load, courses and all, so that units of patterns are nothing to residuals. What is constant is
  // no measure of a vibration.
  std::vector<double> modal, contact; // (N_a), (3 own)
};

// By dof, of the sum of all loads; `pattern_of`: a load's number in the model.
template <class PatternOf>
std::vector<double> amplitudes(const Case &study, const ReducedModel &model, const PatternOf &pattern_of) {
  std::size_t highest = 0;
  for (const LoadCourse &load : study.loads) highest = std::max(highest, load.fourier.size() / 2);
  std::vector<double> out(pattern_of(0).size());
  for (std::size_t k = 1; k <= highest; ++k) {
    std::vector<std::complex<double>> force(out.size());
    for (const LoadCourse &load : study.loads) {
      const auto coefficient = [&load](std::size_t i) { return i < load.fourier.size() ? load.fourier[i] : 0; };
      const std::complex<double> course(coefficient(2 * k - 1), -coefficient(2 * k));
      const auto &pattern = pattern_of(model.load(load.pattern));
      for (std::size_t i = 0; i < force.size(); ++i) force[i] += pattern[i] * course;
    }
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = std::hypot(out[i], std::abs(force[i]));
  }
  return out;
}

Driven driven_first(const Case &study, const ReducedModel &model) {
  const int h = std::abs(study.wave(model.sectors).index(1));
  const SectorIndex *index = h > 0 ? &model.indices[h - 1] : nullptr;
  Driven out;
  out.kaa = index ? index->kaa : model.kaa;
  out.mass.resize(model.own_contact_dofs()), out.stiffness.resize(model.own_contact_dofs());
  if (index) {
    out.modal = amplitudes(
        study, model, [index](std::size_t i) -> const auto & { return index->loads[i].fa; });
    out.contact = amplitudes(
        study, model, [index](std::size_t i) -> const auto & { return index->loads[i].fx; });
  } else {
    out.modal = amplitudes(
        study, model, [&model](std::size_t i) -> const auto & { return model.loads[i].fa; });
    out.contact = amplitudes(
        study, model, [&model](std::size_t i) -> const auto & { return model.loads[i].fx; });
  }
  for (std::size_t i = 0; i < out.mass.size(); ++i) {
    const std::size_t diagonal = i * model.contact_dofs() + 3 * model.own_points.begin + i;
    out.mass[i] = index ? index->mxx[diagonal].real() : model.mxx[diagonal];
    out.stiffness[i] = index ? index->kxx[diagonal].real() : model.kxx[diagonal];
  }
  return out;
}

// Taken from the model.
Scales scales_of(const Case &study, const PreloadedModel &preloaded) {
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
  if (modal_force > 0) scales.modal = modal_force / w2;
  if (modal_force > 0 && largest[3] > 0) {
    scales.contact = scales.modal / std::sqrt(largest[3]); // x weighs like a
    return scales;
  }
  scales.contact = largest[1] > 0 ? largest[1] : largest[0] > 0 && largest[2] > 0 ? largest[0] / largest[2] : 1;
  // without modal force: such that modal and contact accelerations weigh alike
  if (modal_force == 0 && largest[0] > 0) scales.modal = std::sqrt(scales.contact * largest[0] / w2);
  return scales;
}

} // namespace

double Scales::of(const PathParameter &parameter) const {
  using Scale = PathParameter::Scale;
  return parameter.scale == Scale::frequency ? frequency : parameter.scale == Scale::displacement ? contact : 1;
}

Scales choose_scales(const Case &study, const PreloadedModel &preloaded) {
  if (study.scaling == ScalingKind::none) return {};
  if (study.scaling == ScalingKind::manual) return {study.scale_frequency, study.scale_modal, study.scale_contact};
  const Scales scales = scales_of(study, preloaded);
  const double energy = std::pow(scales.modal * scales.frequency, 2);
  if (energy > 0 && std::isfinite(energy)) return scales;
  throw InputError(std::string("[excitation] a load of this size has energies ") + (energy > 0 ? "above" : "below") +
                   " what numbers of the computer can hold; look at its unit");
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
