// Coordinates of a cyclic sector: any motion that they make hangs together as its neighbours want it, and x is what the
// contact points see of it.
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "reduction/sector_coordinates.hpp"
#include "small_model.hpp"
#include "some_sector.hpp"

using namespace dovetail;
using namespace dovetail::testing;
using Complex = std::complex<double>;

namespace {

constexpr PetscInt dofs = 46;

Complex number_of(int i) { return {wave(i, 1), wave(i, 2)}; }

ComplexDense numbers(int rows, int columns) {
  ComplexDense made(rows, columns);
  for (std::size_t i = 0; i < made.values.size(); ++i) made.values[i] = number_of(static_cast<int>(i));
  return made;
}

void expect_same(const ComplexDense &found, const ComplexDense &wanted) {
  ASSERT_EQ(found.rows, wanted.rows);
  ASSERT_EQ(found.columns, wanted.columns);
  for (std::size_t i = 0; i < found.values.size(); ++i)
    EXPECT_NEAR(std::abs(found.values[i] - wanted.values[i]), 0, 1e-12) << i;
}

} // namespace

TEST(SectorCoordinates, make_motions_that_hang_together) {
  for (const int sectors : {6, 7})
    for (int index = 0; index <= sectors / 2; ++index) {
      const CyclicSector sector = sector_of(sectors);
      const auto nodes = held_dofs(sector, dofs);
      const SectorCoordinates E(sector, 3 * static_cast<PetscInt>(nodes.size()), index);
      ASSERT_EQ(E.held(), 3 * static_cast<int>(nodes.size()));
      ASSERT_EQ(E.contact(), 18);
      const ComplexDense y = numbers(E.all(), 1), b = E.to_held(y);
      std::map<PetscInt, Complex> u; // of all dofs b
      for (int i = 0; i < E.held(); ++i) u[nodes[i / 3][i % 3]] = b(i, 0);
      ASSERT_EQ(static_cast<int>(u.size()), E.held());
      const Complex behind = std::polar(1.0, -2 * M_PI * index / sectors);
      const auto turned = [&](const std::array<Complex, 3> &v, int d) {
        return behind * (sector.turn[3 * d] * v[0] + sector.turn[3 * d + 1] * v[1] + sector.turn[3 * d + 2] * v[2]);
      };
      const auto motion = [&](const CyclicSector::Node &node) {
        std::array<Complex, 3> v{};
        for (int d = 0; d < 3; ++d) v[d] = node[d] < 0 ? 0 : u.at(node[d]);
        return v;
      };
      for (const CyclicSector::FaceNode &node : sector.faces) {
        std::array<Complex, 6> left{};
        for (std::size_t i = 0; i < node.direction.size(); ++i) left[node.direction[i]] = u.at(node.left[i]);
        for (std::size_t i = 0; i < node.direction.size(); ++i) {
          const int group = node.direction[i] / 3;
          const Complex wanted =
              turned({left[3 * group], left[3 * group + 1], left[3 * group + 2]}, node.direction[i] % 3);
          EXPECT_NEAR(std::abs(u.at(node.right[i]) - wanted), 0, 1e-12);
        }
      }
      for (std::size_t p = 0; p < sector.contacts.size(); ++p) {
        const CyclicSector::Contact &contact = sector.contacts[p];
        std::array<Complex, 3> apart = motion(contact.a);
        const auto less = [&](const std::array<Complex, 3> &v, double weight) {
          for (int d = 0; d < 3; ++d) apart[d] -= weight * (contact.next ? turned(v, d) : v[d]);
        };
        less(motion(contact.b), 1);
        for (const CyclicSector::Weighted &part : contact.face) less(motion(part.node), part.weight);
        for (int j = 0; j < 3; ++j) {
          Complex x = 0;
          for (int d = 0; d < 3; ++d) x += contact.axes[3 * j + d] * apart[d];
          EXPECT_NEAR(std::abs(x - y(E.own() + static_cast<int>(3 * p) + j, 0)), 0, 1e-12) << p;
        }
      }
      if (index == 0 || 2 * index == sectors) { // real to the last bit
        ComplexDense ones(E.all(), 1);
        std::fill(ones.values.begin(), ones.values.end(), 1.0);
        for (const Complex &value : E.to_held(ones).values) EXPECT_EQ(value.imag(), 0);
      }
    }
}

TEST(SectorCoordinates, products_are_those_of_one_matrix) {
  const CyclicSector sector = sector_of(7);
  const auto nodes = held_dofs(sector, dofs);
  const SectorCoordinates coordinates(sector, 3 * static_cast<PetscInt>(nodes.size()), 2);
  const int n = coordinates.held(), all = coordinates.all(), own = coordinates.own();
  ComplexDense unit(all, all), A(n, n);
  for (int i = 0; i < all; ++i) unit(i, i) = 1;
  const ComplexDense E = coordinates.to_held(unit), b = numbers(n, 2), s = numbers(own, 2);
  expect_same(coordinates.to_held(s), product(E.block(0, 0, n, own), s));
  expect_same(coordinates.own_from_held(b), adjoint_product(E.block(0, 0, n, own), b));
  std::vector<double> values, symmetric(n * n);
  ComplexDense wide(n, 2);
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < 2; ++j) values.push_back(wave(i, 7 + j)), wide(i, j) = values.back();
  expect_same(coordinates.from_held(values.data(), 2), adjoint_product(E, wide));
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) A(i, j) = symmetric[i * n + j] = wave(std::min(i, j), 20 + std::max(i, j));
  expect_same(coordinates.congruent(symmetric), adjoint_product(E, product(A, E)));
}

TEST(SectorCoordinates, dofs_that_are_coordinates_of_contact_points_are_told) {
  const CyclicSector sector = sector_of(7);
  const auto nodes = held_dofs(sector, dofs);
  const SectorCoordinates E(sector, 3 * static_cast<PetscInt>(nodes.size()), 2);
  for (int i = 0; i < E.held(); ++i) {
    const PetscInt dof = nodes[i / 3][i % 3];
    const bool alone =
        dof == 21 || (dof >= 41 && dof <= 43); // by the contact point's own axes, alone and on the ground
    EXPECT_EQ(E.contact_at(i), !alone ? -1 : dof == 21 ? 9 : 15 + dof - 41) << dof;
  }
}

TEST(SectorCoordinates, held_dofs_are_filled_up_to_nodes) {
  CyclicSector sector = sector_of(7);
  sector.faces.pop_back();
  const auto nodes = held_dofs(sector, dofs);
  std::map<PetscInt, int> times;
  for (const auto &node : nodes)
    for (const PetscInt dof : node) ++times[dof];
  EXPECT_EQ(times.size(), 3 * nodes.size());
  EXPECT_EQ(times.size(), 42u); // 40, with the first two others
  EXPECT_TRUE(times.count(19) && times.count(20));
}
