#include "model/cyclic_sector.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <set>

#include "support/error.hpp"
#include "support/hash.hpp"

namespace dovetail {
namespace {

constexpr double round_off = 1e-9;

std::vector<double> three(const h5::Reader &file, const std::string &name) {
  const std::vector<double> values = file.doubles_attribute(name, "/cyclic");
  for (const double value : values)
    if (values.size() != 3 || !std::isfinite(value))
      throw InputError(file.place("/cyclic") + ": attribute " + name + " must be three finite numbers x, y, z");
  return values;
}

// Rodrigues' formula.
CyclicSector::Matrix turn_about(const std::vector<double> &axis, double angle) {
  const double length = std::hypot(axis[0], axis[1], axis[2]), c = std::cos(angle), s = std::sin(angle);
  const double u[] = {axis[0] / length, axis[1] / length, axis[2] / length};
  const double cross[] = {0, -u[2], u[1], u[2], 0, -u[0], -u[1], u[0], 0};
  CyclicSector::Matrix R;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) R[3 * i + j] = (i == j ? c : 0) + s * cross[3 * i + j] + (1 - c) * u[i] * u[j];
  return R;
}

// Node and direction of each dof, from the mesh or, without one, three dofs to a node.
struct DofTable {
  std::vector<long> node, direction;
  std::map<long, std::array<PetscInt, 3>> dofs; // along x, y, z of each node, -1 where there is none

  DofTable(const h5::Reader &file, PetscInt n) {
    if (file.has("/mesh/dof_node")) {
      node = file.integers("/mesh/dof_node"), direction = file.integers("/mesh/dof_direction");
      if (node.size() != std::size_t(n) || direction.size() != std::size_t(n))
        throw InputError(file.place("/mesh/dof_node") + ": one number per dof of /K is wanted of it and of "
                                                        "/mesh/dof_direction");
    } else {
      for (PetscInt dof = 0; dof < n; ++dof) node.push_back(dof / 3), direction.push_back(dof % 3);
    }
    for (PetscInt dof = 0; dof < n; ++dof)
      if (direction[dof] >= 0 && direction[dof] < 3)
        dofs.try_emplace(node[dof], std::array<PetscInt, 3>{-1, -1, -1}).first->second[direction[dof]] = dof;
  }
};

std::vector<long> face(const h5::Reader &file, const std::string &name, PetscInt n) {
  std::vector<long> dofs = file.integers(name);
  if (dofs.empty()) throw InputError(file.place(name) + ": empty; the dofs of a face of the sector are wanted");
  std::set<long> seen;
  for (const long dof : dofs) {
    if (dof < -1 || dof >= n)
      throw InputError(file.place(name) + ": dof " + std::to_string(dof) + " is out of range, 0.." +
                       std::to_string(n - 1) + " wanted, -1 where it is held");
    if (dof >= 0 && !seen.insert(dof).second)
      throw InputError(file.place(name) + ": dof " + std::to_string(dof) + " is repeated");
  }
  return dofs;
}

// A clamp that a turn does not keep leaves a node dofs that the turn mixes with clamped ones.
void check_turn(const h5::Reader &file, const CyclicSector::Matrix &R, const CyclicSector::FaceNode &node, long name) {
  for (const int i : node.direction)
    for (int j = i / 3 * 3; j < i / 3 * 3 + 3; ++j)
      if (std::abs(R[3 * (i % 3) + j % 3]) > round_off &&
          std::find(node.direction.begin(), node.direction.end(), j) == node.direction.end())
        throw InputError(file.place("/cyclic/left") + ": node " + std::to_string(name) +
                         " is held in a direction that a turn about the axis does not keep; hold it in all "
                         "directions, along the axis, or across it");
}

std::vector<CyclicSector::FaceNode> read_faces(const h5::Reader &file, PetscInt n, const DofTable &table,
                                               const CyclicSector::Matrix &R) {
  const std::vector<long> left = face(file, "/cyclic/left", n), right = face(file, "/cyclic/right", n);
  if (left.size() != right.size())
    throw InputError(file.place("/cyclic/right") + ": " + std::to_string(right.size()) +
                     " dofs where /cyclic/left has " + std::to_string(left.size()) +
                     "; one partner for each is wanted");
  const std::set<long> on_left(left.begin(), left.end());
  std::vector<CyclicSector::FaceNode> faces;
  std::map<long, std::size_t> place;
  std::map<long, long> partner;
  for (std::size_t i = 0; i < left.size(); ++i) {
    const long l = left[i], r = right[i];
    if (l < 0 && r < 0) continue;
    if (l < 0 || r < 0)
      throw InputError(file.place("/cyclic/right") + ": dof " + std::to_string(std::max(l, r)) +
                       " has a partner that is held; both move, or neither");
    const long node = table.node[l], other = table.node[r];
    const std::string pair = "dofs " + std::to_string(l) + " and " + std::to_string(r);
    if (on_left.count(r))
      throw InputError(file.place("/cyclic/right") + ": dof " + std::to_string(r) + " is in /cyclic/left, too");
    if (table.direction[l] != table.direction[r] || table.direction[l] < 0)
      throw InputError(file.place("/cyclic/right") + ": " + pair + " are partners of different directions, " +
                       std::to_string(table.direction[l]) + " and " + std::to_string(table.direction[r]));
    if (partner.try_emplace(node, other).first->second != other)
      throw InputError(file.place("/cyclic/right") + ": node " + std::to_string(node) + " has the partners " +
                       std::to_string(partner[node]) + " and " + std::to_string(other) + "; one is wanted");
    const auto [found, is_new] = place.try_emplace(node, faces.size());
    if (is_new) faces.emplace_back();
    CyclicSector::FaceNode &of = faces[found->second];
    of.left.push_back(static_cast<PetscInt>(l)), of.right.push_back(static_cast<PetscInt>(r));
    of.direction.push_back(static_cast<int>(table.direction[l]));
  }
  for (const auto &[node, at] : place) check_turn(file, R, faces[at], node);
  return faces;
}

std::vector<CyclicSector::Contact> read_contacts(const h5::Reader &file, const DofTable &table,
                                                 const std::vector<CyclicSector::FaceNode> &faces) {
  const hsize_t points = sector_points(file);
  const auto nodes = file.integers("/contact/nodes"), next = file.integers("/cyclic/next_sector");
  const auto axes = file.doubles("/contact/axes");
  if (next.size() != points)
    throw InputError(file.place("/cyclic/next_sector") + ": " + std::to_string(next.size()) + " values, " +
                     std::to_string(points) + " wanted (one per contact point, 0 or 1)");
  if (file.extent("/contact/axes") != h5::Extent{points, 3, 3})
    throw InputError(file.place("/contact/axes") + ": rows t1, t2, n of each contact point, (N_x, 3, 3), are wanted");
  std::vector<long> begin(points + 1, 0), on;
  std::vector<double> weights;
  if (file.has("/contact/faces/begin")) {
    begin = file.integers("/contact/faces/begin"), on = file.integers("/contact/faces/node");
    weights = file.doubles("/contact/faces/weight");
    if (begin.size() != points + 1 || begin.front() != 0 || begin.back() != long(on.size()) ||
        weights.size() != on.size() || !std::is_sorted(begin.begin(), begin.end()))
      throw InputError(file.place("/contact/faces") + ": begin (N_x + 1,), node and weight do not fit together");
  }
  std::set<PetscInt> taken; // dofs of the faces, and of nodes of other points
  for (const CyclicSector::FaceNode &node : faces)
    for (const auto *side : {&node.left, &node.right}) taken.insert(side->begin(), side->end());
  const std::set<PetscInt> on_faces = taken;
  std::vector<CyclicSector::Contact> contacts(points);
  for (std::size_t p = 0; p < points; ++p) {
    CyclicSector::Contact &contact = contacts[p];
    const std::string where = " of contact point " + std::to_string(p) + " (counted from 0)";
    if (next[p] != 0 && next[p] != 1)
      throw InputError(file.place("/cyclic/next_sector") + ": " + std::to_string(next[p]) + where +
                       "; 0 or 1 is wanted");
    contact.next = next[p] == 1;
    if (nodes[2 * p] == -1 && nodes[2 * p + 1] == -1)
      throw InputError(file.place("/contact/nodes") + ": both sides" + where +
                       " are held; a side that moves is wanted");
    std::copy_n(&axes[9 * p], 9, contact.axes.begin());
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j <= i; ++j) {
        double product = 0;
        for (int d = 0; d < 3; ++d) product += contact.axes[3 * i + d] * contact.axes[3 * j + d];
        if (!(std::abs(product - (i == j)) < 1e-6))
          throw InputError(file.place("/contact/axes") + ": rows" + where + " are not of length 1 and at right angles");
      }
    for (const auto &[node, dofs] : {std::pair(nodes[2 * p], &contact.a), std::pair(nodes[2 * p + 1], &contact.b)}) {
      if (node == -1) continue;
      const std::string name = "node " + std::to_string(node) + where;
      const auto found = table.dofs.find(node);
      if (found == table.dofs.end() || *std::min_element(found->second.begin(), found->second.end()) < 0)
        throw InputError(file.place("/contact/nodes") + ": " + name +
                         " is clamped in some direction, or is no node; one that moves in x, y and z is wanted");
      *dofs = found->second;
      for (const PetscInt dof : *dofs)
        if (!taken.insert(dof).second)
          throw InputError(file.place("/contact/nodes") + ": " + name +
                           (on_faces.count(dof) ? " is on the left or right face; take contact nodes off the faces"
                                                : " is a contact node already; a node can be one only once"));
    }
    for (long at = begin[p]; at < begin[p + 1]; ++at) {
      const auto found = table.dofs.find(on[at]);
      if (found == table.dofs.end() || contact.has_b() || !std::isfinite(weights[at]))
        throw InputError(file.place("/contact/faces") + ": node " + std::to_string(on[at]) + where +
                         " does not move, or the point has a node b besides, or the weight is no number");
      contact.face.push_back({found->second, weights[at]});
    }
  }
  for (std::size_t p = 0; p < points; ++p)
    for (const CyclicSector::Weighted &part : contacts[p].face)
      for (const PetscInt dof : part.node)
        if (taken.count(dof))
          throw InputError(file.place("/contact/faces") + ": contact point " + std::to_string(p) +
                           " (counted from 0) stands on a node that is a contact node itself, or on the left or right "
                           "face; take another face");
  return contacts;
}

std::uint64_t hash_of(const CyclicSector &sector) {
  std::uint64_t hash = mix(static_cast<std::uint64_t>(sector.sectors));
  const auto take = [&](std::uint64_t value) { hash = mix(hash + value + 1); };
  const auto take_all = [&](const CyclicSector::Matrix &values) {
    for (const double value : values) {
      std::uint64_t bits;
      std::memcpy(&bits, &value, sizeof bits);
      take(bits);
    }
  };
  take_all(sector.turn);
  for (const CyclicSector::FaceNode &node : sector.faces)
    for (std::size_t i = 0; i < node.left.size(); ++i) take(node.left[i]), take(node.right[i]), take(node.direction[i]);
  for (const CyclicSector::Contact &contact : sector.contacts) {
    for (int d = 0; d < 3; ++d) take(contact.a[d]), take(contact.b[d]);
    take(contact.next), take_all(contact.axes);
    for (const CyclicSector::Weighted &part : contact.face) {
      for (const PetscInt dof : part.node) take(dof);
      std::uint64_t bits;
      std::memcpy(&bits, &part.weight, sizeof bits);
      take(bits);
    }
  }
  return hash;
}

} // namespace

int sectors_of_model(const h5::Reader &file) {
  if (!file.has("/cyclic")) return 0;
  const long sectors = file.integer_attribute("sectors", 0, "/cyclic");
  if (sectors < 2 || sectors > 100000)
    throw InputError(file.place("/cyclic") + ": sectors = " + std::to_string(sectors) +
                     "; the number of sectors of the whole, at least 2, is wanted");
  return static_cast<int>(sectors);
}

PetscInt sector_points(const h5::Reader &file) {
  const h5::Extent shape = file.extent("/contact/nodes");
  if (shape.size() != 2 || shape[1] != 2)
    throw InputError(file.place("/contact/nodes") + ": one row of two nodes a, b per contact point is wanted");
  if (file.has("/contact/dofs") && file.extent("/contact/dofs")[0] > 0)
    throw InputError(file.place("/contact/dofs") + ": a cyclic sector has its contact points in /contact/nodes and "
                                                   "/contact/axes; remove this dataset");
  return static_cast<PetscInt>(shape[0]);
}

CyclicSector read_cyclic_sector(const h5::Reader &file, PetscInt n) {
  CyclicSector sector;
  sector.sectors = sectors_of_model(file);
  if (sector.sectors == 0) return sector;
  const std::vector<double> axis = three(file, "axis");
  if (!(std::hypot(axis[0], axis[1], axis[2]) > 0))
    throw InputError(file.place("/cyclic") + ": attribute axis has no length; a direction is wanted");
  sector.turn = turn_about(axis, 2 * M_PI / sector.sectors);
  const DofTable table(file, n);
  sector.faces = read_faces(file, n, table, sector.turn);
  sector.contacts = read_contacts(file, table, sector.faces);
  sector.hash = hash_of(sector);
  return sector;
}

} // namespace dovetail
