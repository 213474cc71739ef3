// What GMRES works with in the modes of the stuck structure, against dense products on one rank: the contacts' part of
// the Jacobian, and the correction among few motions.
#include <gtest/gtest.h>

#include <cmath>

#include "modal/modal_krylov.hpp"
#include "modal_scene.hpp"
#include "support/dense.hpp"

using namespace dovetail;
using namespace dovetail::testing;

namespace {

// The same Jacobian in modes, plainly. Everything is (n, 2H+1).
struct InModes {
  const Scene &scene;
  std::size_t n = scene.layout.dofs(), w = scene.layout.width, all = n * w;

  const StuckBasis &basis(std::size_t k) const { return scene.stuck.of(static_cast<int>(k)); }
  // of harmonic k: R + i I with the sign of its index
  double real(std::size_t k, std::size_t d, std::size_t j) const { return basis(k).exact.row(d)[j]; }
  double imaginary(std::size_t k, std::size_t d, std::size_t j) const {
    const int index = scene.stuck.wave.index(static_cast<int>(k));
    return index == 0 ? 0 : (index < 0 ? -1 : 1) * basis(k).exact.row(d)[n + j];
  }
  Reals motion(const Reals &y, bool adjoint = false) const { // Phi y or Phi^H y, of c - i s
    Reals q(all);
    for (std::size_t a = 0; a < n; ++a)
      for (std::size_t b = 0; b < n; ++b)
        for (std::size_t k = 0; k <= w / 2; ++k) {
          const std::size_t d = adjoint ? b : a, j = adjoint ? a : b;
          const double R = real(k, d, j), I = adjoint ? -imaginary(k, d, j) : imaginary(k, d, j);
          if (k == 0) {
            q[a * w] += R * y[b * w];
            continue;
          }
          const double c = y[b * w + 2 * k - 1], s = y[b * w + 2 * k];
          q[a * w + 2 * k - 1] += R * c + I * s, q[a * w + 2 * k] += R * s - I * c;
        }
    return q;
  }
  Reals contact(const Reals &y) const { // Phi_c^H { dG - kappa K_t } Phi_c y
    const Reals q = motion(y);
    const DynamicStiffness structure = scene.system.structure(scene.omega);
    const std::size_t first = scene.layout.modes * w;
    Reals f(all);
    ContactDerivative(*scene.forces).multiply(&q[first], &f[first]);
    for (std::size_t i = first; i < all; ++i) {
      const double spring = scene.stuck.mean().springs[(i - first) / w];
      const int place = static_cast<int>(i % w), k = (place + 1) / 2;
      f[i] -= spring * q[i];
      if (place > 0) f[i] -= spring * structure.loss(k) * (place % 2 ? q[i + 1] : -q[i - 1]);
    }
    return motion(f, true);
  }
  // Lambda's part, with the damping of K_s or of K alone
  Reals diagonal(const Reals &y, bool of_structure) const {
    const DynamicStiffness structure = scene.system.structure(scene.omega);
    Reals out(all);
    for (std::size_t j = 0; j < n; ++j)
      for (std::size_t k = 0; k <= w / 2; ++k) {
        const int h = static_cast<int>(k);
        const double lambda = basis(k).lambda[j], P = structure.in_phase(h, lambda, 1),
                     Q = structure.quadrature(h, of_structure ? basis(k).damped[j] : lambda, 1);
        if (k == 0) {
          out[j * w] = P * y[j * w];
          continue;
        }
        const double c = y[j * w + 2 * k - 1], s = y[j * w + 2 * k];
        out[j * w + 2 * k - 1] = P * c + Q * s, out[j * w + 2 * k] = P * s - Q * c;
      }
    return out;
  }
  Reals jacobian(const Reals &y) const {
    Reals out = contact(y);
    const Reals more = diagonal(y, false);
    for (std::size_t i = 0; i < all; ++i) out[i] += more[i];
    return out;
  }
};

Reals waves(std::size_t size, int seed) {
  Reals out;
  for (std::size_t i = 0; i < size; ++i) out.push_back(wave(seed, static_cast<int>(i)));
  return out;
}

Reals unit(std::size_t size, std::size_t at) {
  Reals out(size);
  out[at] = 1;
  return out;
}

double difference(const Reals &a, const Reals &b) { // relative
  double most = 0, largest = 0;
  for (std::size_t i = 0; i < b.size(); ++i)
    most = std::max(most, std::abs(a[i] - b[i])), largest = std::max(largest, std::abs(b[i]));
  return most / largest;
}

const Damping damped(0.05, 0.03, 0.02);

} // namespace

TEST(ModalOperator, is_what_contacts_do_in_the_modes) {
  if (!alone()) return;
  for (const bool cyclic : {false, true})
    for (const auto &laws : {std::vector<Law>{}, several})
      for (const double size : {0.01, 1.0, 4.0}) {
        Scene scene(damped, 4, laws, cyclic);
        scene.move(size);
        const InModes dense{scene};
        ModalOperator contacts(scene.stuck, scene.layout, ModalShare(scene.stuck, scene.layout));
        contacts.take(ContactDerivative(*scene.forces), nullptr, scene.system.structure(scene.omega));
        const Reals y = waves(dense.all, 5);
        Reals out(dense.all), q(dense.all), modal(dense.all);
        double last = 3, sum = 4;
        contacts.apply(y.data(), out.data(), last, sum);
        EXPECT_LT(difference(out, dense.contact(y)), 2e-5) << size << cyclic;
        EXPECT_EQ(last, 3);
        EXPECT_EQ(sum, 4);
        contacts.from_modes(y.data(), q.data());
        EXPECT_LT(difference(q, dense.motion(y)), 1e-5);
        Reals sums{1.0 / 3, -7e10 / 9};
        const Reals before = sums;
        std::vector<float> rough{2};
        contacts.to_modes({{y.data(), modal.data()}}, sums, rough);
        EXPECT_LT(difference(modal, dense.motion(y, true)), 1e-5);
        EXPECT_EQ(sums, before);
        EXPECT_EQ(rough[0], 2);
      }
}

TEST(ModalOperator, held_means_are_added) {
  if (!alone()) return;
  Scene scene(damped, 3);
  scene.move(4);
  const InModes dense{scene};
  ModalOperator contacts(scene.stuck, scene.layout, ModalShare(scene.stuck, scene.layout));
  const Reals held = waves(9, 2), y = waves(dense.all, 5);
  Reals out(dense.all), plain(dense.all), f(dense.all);
  double none = 0;
  contacts.take(ContactDerivative(*scene.forces), nullptr, scene.system.structure(scene.omega));
  contacts.apply(y.data(), plain.data(), none, none);
  contacts.take(ContactDerivative(*scene.forces), held.data(), scene.system.structure(scene.omega));
  contacts.apply(y.data(), out.data(), none, none);
  const Reals q = dense.motion(y);
  for (std::size_t d = 0; d < 9; ++d) f[(2 + d) * dense.w] = held[d] * q[(2 + d) * dense.w];
  const Reals more = dense.motion(f, true);
  for (std::size_t i = 0; i < plain.size(); ++i) plain[i] += more[i];
  EXPECT_LT(difference(out, plain), 1e-5);
}

TEST(ModalOperator, among_motions_it_is_the_same) {
  if (!alone()) return;
  for (const bool cyclic : {false, true})
    for (const double size : {0.01, 4.0}) {
      Scene scene(damped, 4, cyclic ? several : std::vector<Law>{}, cyclic);
      scene.move(size);
      const InModes dense{scene};
      ModalOperator contacts(scene.stuck, scene.layout, ModalShare(scene.stuck, scene.layout));
      contacts.take(ContactDerivative(*scene.forces), nullptr, scene.system.structure(scene.omega));
      std::vector<ModalOperator::Motions> motions;
      struct Unknown {
        std::size_t mode, coefficient;
      };
      std::vector<Unknown> unknowns; // of the first few modes, another number in each group
      for (const IndexGroup &group : groups_of(scene.stuck.wave, scene.layout.width)) {
        ModalOperator::Motions of{group, 3 + group.index, {}, {}};
        for (std::size_t d = 2; d < 11; ++d)
          for (PetscInt m = 0; m < of.count; ++m) {
            const double *row = scene.stuck.of_index[group.index]->exact.row(d);
            of.real.push_back(static_cast<float>(row[m]));
            if (group.complex) of.imaginary.push_back(static_cast<float>(row[11 + m]));
          }
        for (const int c : group.coefficients)
          for (PetscInt m = 0; m < of.count; ++m)
            unknowns.push_back({static_cast<std::size_t>(m), static_cast<std::size_t>(c)});
        motions.push_back(std::move(of));
      }
      const std::vector<float> found = contacts.among(motions);
      const std::size_t count = unknowns.size();
      ASSERT_EQ(found.size(), count * count);
      Reals wanted, given(found.begin(), found.end());
      for (const Unknown &of : unknowns) {
        const Reals answer = dense.contact(unit(dense.all, of.mode * dense.w + of.coefficient));
        for (const Unknown &to : unknowns) wanted.push_back(answer[to.mode * dense.w + to.coefficient]);
      }
      EXPECT_LT(difference(given, wanted), 2e-5) << size << cyclic;
    }
}

TEST(ModalOperator, work_is_that_of_products_with_contact_rows) {
  for (const bool cyclic : {false, true}) {
    Scene scene(damped, 4, {}, cyclic);
    const ModalShare share(scene.stuck, scene.layout);
    double wanted = 0;
    for (const IndexGroup &group : groups_of(scene.stuck.wave, scene.layout.width))
      wanted += 9 * (group.complex ? 22 : 11) * (4.0 * group.columns() + (group.whole ? 0 : 12));
    EXPECT_DOUBLE_EQ(ModalOperator(scene.stuck, scene.layout, share).work(), wanted);
    EXPECT_DOUBLE_EQ(ModalKrylov(scene.stuck, scene.layout).work(), wanted + 60.0 * 9 * 11 + 3e5);
  }
}

// B in closed form or by its columns; then (B^H J B)^-1 - (B^H D B)^-1.
TEST(CoarseSpace, corrects_as_inverses_among_its_motions_do) {
  if (!alone()) return;
  for (const bool cyclic : {false, true})
    for (const char *lowest : {"3", "1000"}) {
      const Option modes("-hb_modal_lowest", lowest);
      Scene scene(damped, 4, cyclic ? several : std::vector<Law>{}, cyclic);
      scene.move(3);
      const InModes dense{scene};
      const DynamicStiffness structure = scene.system.structure(scene.omega);
      const ModalShare share(scene.stuck, scene.layout);
      ModalOperator contacts(scene.stuck, scene.layout, share);
      contacts.take(ContactDerivative(*scene.forces), nullptr, structure);
      CoarseSpace space(scene.stuck, scene.layout, share);
      ASSERT_TRUE(space.used());
      EXPECT_EQ(space.size(), 0);
      EXPECT_EQ(space.sign(), 1);
      space.factor(space.part(contacts, structure), structure);
      const std::size_t size = space.size();
      std::vector<Reals> B;
      for (std::size_t i = 0; i < size; ++i) {
        B.emplace_back(dense.all);
        space.add(unit(size, i).data(), B.back().data());
      }
      std::size_t first = 0; // of each group: its lowest modes, then shapes without these
      for (const IndexGroup &group : groups_of(scene.stuck.wave, scene.layout.width)) {
        const StuckBasis &basis = *scene.stuck.of_index[group.index];
        const std::size_t low = lowest[0] == '3' ? 3 : 11, all = basis.shapes.size() / (group.complex ? 22 : 11),
                          count = low + std::min(all, 11 - low);
        for (const int c : group.coefficients)
          for (std::size_t m = 0; m < count; ++m, ++first)
            for (std::size_t i = 0; i < dense.all; ++i) {
              const std::size_t mode = i / dense.w;
              const bool same = static_cast<int>(i % dense.w) == c;
              if (m < low)
                EXPECT_EQ(B[first][i], mode == m && same);
              else if (same)
                EXPECT_NEAR(B[first][i], mode < low ? 0 : basis.shapes[(m - low) * (group.complex ? 22 : 11) + mode],
                            1e-12);
              else if (!group.complex)
                EXPECT_EQ(B[first][i], 0);
            }
      }
      EXPECT_EQ(first, size);
      const Reals v = waves(dense.all, 6);
      Reals along(size), wanted;
      space.to_motions(v.data(), along.data());
      for (const Reals &b : B) wanted.push_back(std::inner_product(b.begin(), b.end(), v.begin(), 0.0));
      EXPECT_LT(difference(along, wanted), 1e-12);
      const auto among = [&](bool of_all, bool transposed) {
        Dense A(static_cast<int>(size), static_cast<int>(size));
        for (std::size_t j = 0; j < size; ++j) {
          const Reals Ab = of_all ? dense.jacobian(B[j]) : dense.diagonal(B[j], true);
          for (std::size_t i = 0; i < size; ++i) {
            const double value = std::inner_product(B[i].begin(), B[i].end(), Ab.begin(), 0.0);
            (transposed ? A(static_cast<int>(j), static_cast<int>(i)) : A(static_cast<int>(i), static_cast<int>(j))) =
                value;
          }
        }
        Factors factors;
        EXPECT_TRUE(factors.factor(A));
        return factors;
      };
      for (const bool transposed : {false, true}) {
        const Factors J = among(true, transposed), D = among(false, transposed);
        Reals g = waves(size, 8), by_J = g, by_D = g;
        space.solve(g.data(), transposed);
        J.solve(by_J.data()), D.solve(by_D.data());
        for (std::size_t i = 0; i < size; ++i) by_J[i] -= by_D[i];
        EXPECT_LT(difference(g, by_J), 2e-3) << cyclic << lowest << transposed;
        EXPECT_EQ(space.sign(), J.sign());
      }
      space.forget();
      EXPECT_EQ(space.size(), 0);
    }
}
