// Units that look mixed: what a meshed model weighs, how large it is, and how fast waves run in it.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <optional>

#include "app/check.hpp"
#include "model/mesh_dofs.hpp"
#include "support/error.hpp"
#include "support/hdf5.hpp"
#include "support/unit_sizes.hpp"

namespace dovetail {
namespace {

// Of materials that are built with, with a margin for what clamped nodes take away and for a rough estimate.
constexpr std::pair<double, double> sizes{1e-4, 1e3}, densities{300, 30000}, speeds{300, 30000}; // [m], [kg/m^3], [m/s]

bool within(double value, const std::pair<double, double> &range) {
  return range.first <= value && value <= range.second;
}

struct Solid { // in units of the model
  double across = 0, volume = 0, density = 0, speed = 0;
  bool fits(const UnitSizes &in) const {
    return within(across * in.metres, sizes) && within(density * in.kilograms / std::pow(in.metres, 3), densities) &&
           within(speed * in.metres / in.seconds, speeds);
  }
};

// Tetrahedra by the corners of a cell.
using Split = std::vector<std::array<int, 4>>;
const Split *split_of(const std::string &type) {
  static const std::map<std::string, Split> known = {
      {"tetra", {{0, 1, 2, 3}}},
      {"hexahedron", {{0, 1, 2, 6}, {0, 2, 3, 6}, {0, 3, 7, 6}, {0, 7, 4, 6}, {0, 4, 5, 6}, {0, 5, 1, 6}}},
      {"wedge", {{0, 1, 2, 3}, {1, 2, 3, 4}, {2, 3, 4, 5}}},
      {"pyramid", {{0, 1, 2, 4}, {0, 2, 3, 4}}}};
  const auto found = known.find(type.substr(0, type.find_first_of("0123456789")));
  return found == known.end() ? nullptr : &found->second;
}

double volume_of(const h5::Reader &file, const std::vector<double> &nodes) {
  double volume = 0;
  if (!file.has("/mesh/cells")) return 0;
  for (const std::string &type : file.members("/mesh/cells")) {
    const Split *split = split_of(type);
    if (!split) continue;
    const std::vector<long> rows = file.integers("/mesh/cells/" + type);
    const std::size_t width = file.extent("/mesh/cells/" + type).at(1);
    for (std::size_t cell = 0; cell + width <= rows.size(); cell += width)
      for (const auto &corners : *split) {
        double edge[3][3];
        for (int i = 0; i < 3; ++i)
          for (int d = 0; d < 3; ++d)
            edge[i][d] = nodes.at(3 * rows[cell + corners[i + 1]] + d) - nodes.at(3 * rows[cell + corners[0]] + d);
        volume += std::abs(edge[0][0] * (edge[1][1] * edge[2][2] - edge[1][2] * edge[2][1]) -
                           edge[0][1] * (edge[1][0] * edge[2][2] - edge[1][2] * edge[2][0]) +
                           edge[0][2] * (edge[1][0] * edge[2][1] - edge[1][1] * edge[2][0])) /
                  6;
      }
  }
  return volume;
}

// (n) of a rigid motion along a direction. Where a joint has changed dofs, those of its points are relative, and do
// not move; of a pair of nodes the others are sums of two.
std::vector<double> rigid_motion(const FullModel &model, const ChangedDofs &changed, const std::vector<long> &direction,
                                 int along) {
  std::vector<double> motion(model.dofs, 0.0);
  for (PetscInt dof = 0; dof < model.dofs; ++dof) motion[dof] = direction[dof] == along;
  for (const long dof : changed.dof) motion.at(dof) *= 2;
  for (const auto &dofs : model.contact_dofs)
    for (const PetscInt dof : dofs) motion[dof] = 0;
  return motion;
}

double mass_of(const FullModel &model, const std::vector<double> &motion) {
  UniqueVec r, product;
  PetscInt first, last;
  PetscScalar *own, mass;
  check(MatCreateVecs(model.M, r.out(), product.out()), "weighing the model");
  check(VecGetOwnershipRange(r, &first, &last), "weighing the model");
  check(VecGetArray(r, &own), "weighing the model");
  std::copy(motion.begin() + first, motion.begin() + last, own);
  check(VecRestoreArray(r, &own), "weighing the model");
  check(MatMult(model.M, r, product), "weighing the model");
  check(VecDot(r, product, &mass), "weighing the model");
  return mass;
}

// Geometric mean of K_ii / M_ii of displacements, from which springs and stiff parts hardly stand out.
double mean_square(const FullModel &model, const std::vector<long> &direction) {
  UniqueVec k, m;
  PetscInt first, last;
  const PetscScalar *own_k, *own_m;
  check(MatCreateVecs(model.K, k.out(), m.out()), "looking at diagonals");
  check(MatGetDiagonal(model.K, k), "looking at diagonals");
  check(MatGetDiagonal(model.M, m), "looking at diagonals");
  check(VecGetOwnershipRange(k, &first, &last), "looking at diagonals");
  check(VecGetArrayRead(k, &own_k), "looking at diagonals");
  check(VecGetArrayRead(m, &own_m), "looking at diagonals");
  double sums[2] = {0, 0};
  for (PetscInt i = 0; i < last - first; ++i)
    if (const long along = direction[first + i]; along >= 0 && along < 3 && own_k[i] > 0 && own_m[i] > 0)
      sums[0] += std::log(own_k[i] / own_m[i]), sums[1] += 1;
  check(VecRestoreArrayRead(k, &own_k), "looking at diagonals");
  check(VecRestoreArrayRead(m, &own_m), "looking at diagonals");
  MPI_Allreduce(MPI_IN_PLACE, sums, 2, MPI_DOUBLE, MPI_SUM, model.comm);
  return sums[1] > 0 ? std::exp(sums[0] / sums[1]) : 0;
}

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

} // namespace

std::vector<Warning> doubts_of_units(const FullModel &model) {
  // A node of solid elements of size h has K_ii / M_ii of about 6 (c / h)^2: of hexahedra with linear shapes 6.4 at
  // Poisson's ratio 0.3.
  constexpr double of_a_node = 6;
  std::vector<double> nodes;
  std::vector<long> direction;
  ChangedDofs changed;
  Solid solid;
  on_all_ranks(model.comm, [&] {
    const h5::Reader file(model.file);
    if (!file.has("/mesh/nodes") || !file.has("/mesh/dof_direction")) return;
    nodes = file.doubles("/mesh/nodes"), direction = file.integers("/mesh/dof_direction");
    changed = changed_dofs(file, model.dofs);
    solid.volume = volume_of(file, nodes);
  });
  if (solid.volume <= 0 || direction.size() != static_cast<std::size_t>(model.dofs)) return {};
  double square = 0, mass = 0;
  for (int d = 0; d < 3; ++d) {
    double low = INFINITY, high = -INFINITY;
    for (std::size_t i = d; i < nodes.size(); i += 3) low = std::min(low, nodes[i]), high = std::max(high, nodes[i]);
    square += (high - low) * (high - low);
    mass = std::max(mass, mass_of(model, rigid_motion(model, changed, direction, d))); // some may be held along one
  }
  const double size = std::cbrt(3 * solid.volume / static_cast<double>(nodes.size()));
  solid.across = std::sqrt(square), solid.density = mass / solid.volume;
  solid.speed = size * std::sqrt(mean_square(model, direction) / of_a_node);
  const std::optional<UnitSizes> in = unit_sizes_of(model.units);
  const std::vector<std::string> usual = {"kg, m, s", "t, mm, s", "kg, mm, ms", "g, mm, ms", "lbf, in, s"};
  const auto other = std::find_if(usual.begin(), usual.end(),
                                  [&](const std::string &label) { return solid.fits(*unit_sizes_of(label)); });
  if (in ? solid.fits(*in) : other != usual.end()) return {};
  std::string text = "units look mixed: by the mesh, K and M, ";
  if (!in)
    text += "the structure is " + number(solid.across) + " across, its density " + number(solid.density) +
            " and its wave speed some " + number(solid.speed) + ", which fit no usual system of units";
  else
    text += "with the label \"" + model.units + "\", the structure is " + number(solid.across * in->metres) +
            " m across, of " + number(solid.density * in->kilograms / std::pow(in->metres, 3)) +
            " kg/m^3, and waves run at some " + number(solid.speed * in->metres / in->seconds) +
            " m/s; of steel these are 7850 and 5000" +
            (other == usual.end() ? "" : ". The numbers would fit the label \"" + *other + "\"");
  std::vector<Warning> out;
  out.push_back({"units", text});
  return out;
}

} // namespace dovetail
