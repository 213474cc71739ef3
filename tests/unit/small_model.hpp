#pragma once
// A made-up reduced model with three contact points, small enough to know by heart, on any number of ranks.
#include <cmath>

#include "contact/contact_change.hpp"
#include "preload/contact_preload.hpp"
#include "scaling/scaled_model.hpp"

namespace dovetail::testing {

inline double wave(int i, int j) { return std::sin(1.0 + 3.7 * i + 2.3 * j); } // numbers without structure

/// The pattern /force alone, with that course.
inline std::vector<LoadCourse> course(std::vector<double> fourier) { return {{force_pattern, std::move(fourier), ""}}; }

/// N_a = 2, N_x = 3; K_xx and M_xx well conditioned.
inline ReducedModel small_reduced(MPI_Comm comm) {
  ReducedModel model;
  model.comm = comm;
  model.modes = 2, model.points = 3;
  model.own_modes = own_share(comm, model.modes);
  model.own_points = own_share(comm, model.points);
  model.kaa = {1.0, 4.0};
  model.loads[0].fa = {1.0, -0.4};
  const int nc = 9;
  for (int i = 3 * model.own_points.begin; i < 3 * model.own_points.end; ++i) {
    for (int j = 0; j < 2; ++j) model.mxa.push_back(0.2 * wave(i, j));
    for (int j = 0; j < nc; ++j) {
      model.kxx.push_back((i == j ? 6.0 : 0.0) + 0.3 * (wave(i, j) + wave(j, i)));
      model.mxx.push_back((i == j ? 1.0 : 0.0) + 0.03 * (wave(i, j + 9) + wave(j, i + 9)));
    }
    model.loads[0].fx.push_back(0.5 * wave(i, 40));
    model.r.push_back(i % 3 == 2 ? -2.0 : 0.3 * wave(i, 50)); // presses the joint together
  }
  return model;
}

/// K and M of the small model, whole (11, 11): modes first.
struct SmallMatrices {
  static constexpr std::size_t n = 11;
  std::vector<double> K = std::vector<double>(n * n), M = K;
  SmallMatrices() {
    const ReducedModel whole = small_reduced(PETSC_COMM_SELF);
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < n; ++j) {
        const bool mi = i < 2, mj = j < 2;
        K[i * n + j] = mi && mj ? (i == j) * whole.kaa[i] : mi || mj ? 0 : whole.kxx[(i - 2) * 9 + j - 2];
        M[i * n + j] = mi && mj ? i == j
                       : mi     ? whole.mxa[(j - 2) * 2 + i]
                       : mj     ? whole.mxa[(i - 2) * 2 + j]
                                : whole.mxx[(i - 2) * 9 + j - 2];
      }
  }
};

/// The matrices that a kind of damping wants of a model, proportional to nothing.
inline void add_damping_matrices(const Damping &damping, ReducedModel &model) {
  const auto fill = [&](DampingMatrix &matrix, double size) {
    const auto value = [&](int i, int j) { // of a sum of three squares
      double sum = 0;
      for (int d = 0; d < 3; ++d) sum += wave(i, 80 + d) * wave(j, 80 + d);
      return size * sum;
    };
    matrix.given = true;
    for (int i = 0; i < 2; ++i)
      for (int j = 0; j < 2; ++j) matrix.aa.push_back(value(i, j));
    for (int i = 2 + 3 * model.own_points.begin; i < 2 + 3 * model.own_points.end; ++i)
      for (int j = 0; j < 11; ++j) (j < 2 ? matrix.xa : matrix.xx).push_back(value(i, j));
  };
  if (damping.matrix) fill(model.viscous, 0.04);
  if (damping.of_parts) fill(model.structural, 0.7);
}

inline std::vector<ContactPoint> small_contact(const ReducedModel &model) {
  const ContactPoint all[] = {{Law::coulomb, 5, {3, 4}, {0.2, 0.3}, 0},
                              {Law::coulomb, 4, {2, 2}, {0.5, 0.4}, -0.1},
                              {Law::coulomb, 6, {3, 3}, {5, 5}, 0}};
  return {all + model.own_points.begin, all + model.own_points.end};
}

/// The small model with a law for each point, at a setting of its joint. With a tangential `pull` of 12, points slip at
/// the preload. `varied`: (N_x) points that the setting is of; empty: all.
inline PreloadedModel preloaded(const std::vector<Law> &law, double pull, const Setting &setting,
                                const std::vector<bool> &varied = {}) {
  ReducedModel model = small_reduced(PETSC_COMM_WORLD);
  std::vector<ContactPoint> contact = small_contact(model);
  for (std::size_t p = 0; p < contact.size(); ++p) {
    contact[p].law = law[model.own_points.begin + p];
    if (contact[p].law == Law::cone) contact[p].mu[1] = contact[p].mu[0];
    if (varied.empty() || varied[model.own_points.begin + p]) contact[p] = changed(contact[p], setting.contact);
  }
  for (std::size_t i = 0; i < model.r.size(); ++i) model.r[i] *= (i % 3 == 2 ? 1 : pull) * setting.preload;
  std::string note;
  const std::vector<double> zero(model.own_contact_dofs(), 0.0);
  return contact_preload(std::move(model), std::move(contact), zero, note);
}

inline PreloadedModel small_preloaded(MPI_Comm comm) {
  ReducedModel model = small_reduced(comm);
  auto contact = small_contact(model);
  std::string note;
  const std::vector<double> zero(model.own_contact_dofs(), 0.0);
  return contact_preload(std::move(model), std::move(contact), zero, note);
}

/// Points of mass 1 on springs to the ground, of each contact dof its own, and nothing between them.
template <class Stiffness> ReducedModel grounded(int points, const Stiffness &stiffness) {
  ReducedModel model;
  model.comm = PETSC_COMM_WORLD, model.points = points;
  model.own_points = own_share(model.comm, points), model.own_modes = own_share(model.comm, 0);
  for (int i = 3 * model.own_points.begin; i < 3 * model.own_points.end; ++i)
    for (int j = 0; j < 3 * points; ++j) model.kxx.push_back(i == j ? stiffness(i) : 0), model.mxx.push_back(i == j);
  return model;
}

} // namespace dovetail::testing
