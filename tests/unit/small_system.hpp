#pragma once
// The small model as a harmonic system, and vectors of its unknowns.
#include "harmonic/dense_model.hpp"
#include "harmonic/harmonic_system.hpp"
#include "norms.hpp"
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
  add_damping_matrices(damping, model.reduced);
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

/// |x - y| / |y| of residual, and of Jacobian times a vector, between both forms of the linear part, at a motion of
/// that size.
inline std::pair<double, double> forms_differ(int samples, const std::vector<Law> &laws, const Damping &damping,
                                              double size) {
  HarmonicSystem assembled = small_system(LinearForm::assembled, samples, laws, damping),
                 modal = small_system(LinearForm::modal, samples, laws, damping);
  const UniqueVec y = vector_of(modal, size, 3, 1.3), v = vector_of(modal, 1, 5, 0.7),
                  border = vector_of(modal, 1, 7, 0.2);
  UniqueVec f = modal.unknowns(), g = modal.unknowns();
  assembled.residual(y, f), modal.residual(y, g);
  const double residual = relative_difference(g, f);
  const UniqueMat A = assembled.matrix(), B = modal.matrix();
  assembled.jacobian(y, border, A), modal.jacobian(y, border, B);
  check(MatMult(A, v, f), "");
  check(MatMult(B, v, g), "");
  return {residual, relative_difference(g, f)};
}

} // namespace dovetail::testing
