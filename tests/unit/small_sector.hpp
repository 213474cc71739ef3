#pragma once
// A sector of a cyclic structure without structure else, and harmonic systems of it.
#include <complex>

#include "preload/contact_preload.hpp"
#include "small_system.hpp"

namespace dovetail::testing {

using Complex = std::complex<double>;

constexpr int sectors = 6, harmonics = 4;
inline const std::vector<double> fourier = {0.2, 1.0, 0.3, 0.1, 0.2, 0.05};

// Hermitian and without structure else.
inline Complex entry(int i, int j, int seed) {
  return {wave(i, j + seed) + wave(j, i + seed), wave(i + 7, j + seed) - wave(j + 7, i + seed)};
}

/// small_reduced() as index 0 of six sectors.
inline ReducedModel small_sector() {
  ReducedModel model = small_reduced(PETSC_COMM_WORLD);
  model.sectors = sectors;
  for (int h = 1; h <= sectors / 2; ++h) {
    SectorIndex index;
    index.kaa = {1.0 + 0.2 * h, 4.0 + 0.3 * h};
    SectorIndex::Load load{{{1.0, 0.2 * h}, {-0.4, 0.1}}, {}};
    for (int i = 3 * model.own_points.begin; i < 3 * model.own_points.end; ++i) {
      for (int j = 0; j < 2; ++j) index.mxa.emplace_back(0.2 * wave(i, j + h), 0.1 * wave(j, i + h));
      for (int j = 0; j < 9; ++j) {
        index.kxx.push_back(0.3 * entry(i, j, h) + (i == j ? 6.0 : 0.0));
        index.mxx.push_back(0.03 * entry(i, j, 30 + h) + (i == j ? 1.0 : 0.0));
      }
      load.fx.emplace_back(0.5 * wave(i, 40 + h), 0.3 * wave(i, 60 + h));
    }
    index.loads = {load};
    model.indices.push_back(std::move(index));
  }
  return model;
}

inline HarmonicSystem sector_system(int engine_order, int samples = exactly, const std::vector<Law> &laws = {},
                                    const Damping &damping = 0.05, const Scales &scales = {}, bool cyclic = true,
                                    LinearForm form = LinearForm::assembled) {
  ReducedModel model = cyclic ? small_sector() : small_reduced(PETSC_COMM_WORLD);
  std::vector<ContactPoint> contact = small_contact(model);
  std::string note;
  const std::vector<double> zero(model.own_contact_dofs(), 0.0);
  PreloadedModel preloaded = contact_preload(std::move(model), std::move(contact), zero, note);
  for (std::size_t p = 0; !laws.empty() && p < preloaded.contact.size(); ++p)
    preloaded.contact[p].law = laws[preloaded.reduced.own_points.begin + p];
  ScaledModel made = scaled(std::move(preloaded), damping, scales);
  made.engine_order = engine_order;
  return HarmonicSystem(std::move(made), harmonics, samples, course(fourier), form);
}

} // namespace dovetail::testing
