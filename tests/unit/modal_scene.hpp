#pragma once
// Jacobians of the small models, assembled, and as the parts that those which solve in modes are given.
#include <memory>

#include "modal/contact_factors.hpp"
#include "small_sector.hpp"
#include "support/shell.hpp"

namespace dovetail::testing {

using Reals = std::vector<double>;

inline ScaledModel model_of(const Damping &damping, const std::vector<Law> &laws, bool cyclic) {
  ReducedModel reduced = cyclic ? small_sector() : small_reduced(PETSC_COMM_WORLD);
  std::vector<ContactPoint> contact = small_contact(reduced);
  std::string note;
  const Reals zero(reduced.own_contact_dofs(), 0.0);
  PreloadedModel preloaded = contact_preload(std::move(reduced), std::move(contact), zero, note);
  for (std::size_t p = 0; !laws.empty() && p < preloaded.contact.size(); ++p)
    preloaded.contact[p].law = laws[preloaded.reduced.own_points.begin + p];
  ScaledModel made = scaled(std::move(preloaded), damping, {});
  if (cyclic) made.engine_order = 1;
  return made;
}

// The bases of a model with those springs, of all indices that harmonics have.
inline StuckBases bases_of(const ScaledModel &scaled, const Layout &layout, bool stuck) {
  const ReducedModel &model = scaled.model.reduced;
  Reals springs = stuck_springs(scaled.model.contact);
  if (!stuck) std::fill(springs.begin(), springs.end(), 0.0);
  StuckBases bases;
  bases.wave = {model.sectors, scaled.engine_order};
  bases.of_index.push_back(std::make_shared<StuckBasis>(stuck_basis(model, springs, layout)));
  for (const SectorIndex &index : model.indices)
    bases.of_index.push_back(std::make_shared<StuckBasis>(std::move(stuck_bases(model, {&index}, springs, layout)[0])));
  return bases;
}

// The Jacobian at a motion, assembled; and the same as its parts.
struct Scene {
  explicit Scene(const Damping &damping, int harmonics_, const std::vector<Law> &laws = {}, bool cyclic = false)
      : layout(model_of(damping, laws, cyclic).model.reduced, harmonics_), scaled(model_of(damping, laws, cyclic)),
        stuck(bases_of(scaled, layout, true)),
        system(model_of(damping, laws, cyclic), harmonics_, exactly, course(fourier), LinearForm::assembled) {}

  void move(const Reals &all, int seed = 7) {
    UniqueVec y = system.unknowns();
    set_coefficients(layout, all, y);
    const ReadValues q(y);
    system.evaluate(q);
    const UniqueVec a = vector_of(system, 1, 21, 0), b = vector_of(system, 1, seed, 0.2);
    const ReadValues from_a(a), from_b(b);
    column.assign(from_a + 0, from_a + layout.own_coefficients());
    border.assign(from_b + 0, from_b + layout.own_unknowns());
    J = system.matrix();
    system.fill(J, system.structure(omega), column.data(), border.data());
  }
  void move(double size, int seed = 7) {
    Reals all(static_cast<std::size_t>(layout.dofs()) * layout.width);
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = size * wave(3, static_cast<int>(i));
    move(all, seed);
  }
  JacobianParts parts() const {
    return {system.structure(omega), ContactDerivative(*forces), nullptr, column.data(), border.data()};
  }
  /// |J x - r| / |r| of what `solve` makes of some r.
  template <class Solve> double missed(const Solve &solve) const {
    const UniqueVec r = vector_of(system, 1, 9, 0.4);
    UniqueVec x = system.unknowns(), product = system.unknowns();
    solve(r, x);
    check(MatMult(J, x, product), "");
    return relative_difference(product, r);
  }
  double missed_by(ModalFactors &factors) const {
    return missed([&](Vec r, Vec x) { factors.solve(ReadValues(r), Values(x)); });
  }
  int sign() const { // of the determinant, by MUMPS
    UniqueKSP ksp;
    check(KSPCreate(PETSC_COMM_WORLD, ksp.out()), "");
    system.set_up(ksp, J);
    check(KSPSetOperators(ksp, J, J), "");
    check(KSPSetUp(ksp), "");
    return system.determinant_sign(ksp);
  }

  Layout layout;
  ScaledModel scaled;
  StuckBases stuck;
  HarmonicSystem system;
  const ContactForces *forces = &system.contact_forces();
  double omega = 1.3;
  Reals column, border;
  UniqueMat J;
};

inline const std::vector<Law> several{Law::unilateral, Law::cone, Law::bilateral};

} // namespace dovetail::testing
