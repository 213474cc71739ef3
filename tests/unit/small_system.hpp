#pragma once
// The small model as a harmonic system, and vectors of its unknowns.
#include "harmonic/dense_model.hpp"
#include "harmonic/harmonic_system.hpp"
#include "small_model.hpp"
#include "support/error.hpp"

namespace dovetail::testing {

class Option { // of PETSc, while it lives
public:
  Option(const char *name, const char *value) : name_(name) { check(PetscOptionsSetValue(nullptr, name, value), ""); }
  ~Option() { PetscOptionsClearValue(nullptr, name_); }

private:
  const char *name_;
};

inline HarmonicSystem small_system(LinearForm form, int samples = exactly, const std::vector<Law> &laws = {},
                                   const Damping &damping = 0.05) {
  PreloadedModel model = small_preloaded(PETSC_COMM_WORLD);
  for (std::size_t p = 0; !laws.empty() && p < model.contact.size(); ++p)
    model.contact[p].law = laws[model.reduced.own_points.begin + p];
  return HarmonicSystem(scaled(std::move(model), damping, {}), 3, samples, course({0.2, 1.0, 0.3}), form);
}

inline UniqueVec vector_of(const HarmonicSystem &system, double size, int seed, double last) {
  UniqueVec y = system.unknowns();
  const Layout &layout = system.layout();
  std::vector<double> all(static_cast<std::size_t>(layout.dofs()) * layout.width);
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = size * wave(seed, static_cast<int>(i));
  set_coefficients(layout, all, y);
  if (layout.owns_omega()) check(VecSetValue(y, layout.omega_row(), last, INSERT_VALUES), "");
  check(VecAssemblyBegin(y), "");
  check(VecAssemblyEnd(y), "");
  return y;
}

inline double norm(Vec v) {
  PetscReal value;
  check(VecNorm(v, NORM_2, &value), "");
  return value;
}

inline double relative_difference(Vec a, Vec b) {
  UniqueVec c;
  check(VecDuplicate(a, c.out()), "");
  check(VecWAXPY(c, -1, a, b), "");
  return norm(c) / norm(b);
}

} // namespace dovetail::testing
