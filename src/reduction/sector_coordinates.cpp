#include "reduction/sector_coordinates.hpp"

#include <algorithm>
#include <cmath>

#include "support/error.hpp"

namespace dovetail {
namespace {

// exp(i 2 pi h / N), exact where it is real: then all that follows is.
std::complex<double> phase_of(int index, int sectors) {
  if (index == 0) return 1;
  if (2 * index == sectors) return -1;
  return std::polar(1.0, 2 * M_PI * index / sectors);
}

// Dofs of nodes on whose faces contact nodes stand, each once.
std::vector<PetscInt> carriers(const CyclicSector &sector) {
  std::vector<PetscInt> dofs;
  for (const CyclicSector::Contact &contact : sector.contacts)
    for (const CyclicSector::Weighted &part : contact.face)
      for (const PetscInt dof : part.node)
        if (dof >= 0) dofs.push_back(dof);
  std::sort(dofs.begin(), dofs.end());
  dofs.erase(std::unique(dofs.begin(), dofs.end()), dofs.end());
  return dofs;
}

} // namespace

std::vector<std::array<PetscInt, 3>> held_dofs(const CyclicSector &sector, PetscInt dofs) {
  std::vector<PetscInt> flat;
  for (const CyclicSector::Contact &contact : sector.contacts) {
    if (contact.has_a()) flat.insert(flat.end(), contact.a.begin(), contact.a.end());
    if (contact.has_b()) flat.insert(flat.end(), contact.b.begin(), contact.b.end());
  }
  const std::vector<PetscInt> carrying = carriers(sector);
  flat.insert(flat.end(), carrying.begin(), carrying.end());
  for (const auto side : {&CyclicSector::FaceNode::left, &CyclicSector::FaceNode::right})
    for (const CyclicSector::FaceNode &node : sector.faces)
      flat.insert(flat.end(), (node.*side).begin(), (node.*side).end());
  std::vector<char> taken(dofs, 0);
  for (const PetscInt dof : flat) taken[dof] = 1;
  for (PetscInt dof = 0; dof < dofs && flat.size() % 3 != 0; ++dof)
    if (!taken[dof]) flat.push_back(dof);
  if (flat.size() % 3 != 0)
    throw InputError("a cyclic sector needs nodes inside, off its faces and contact points; there are none");
  std::vector<std::array<PetscInt, 3>> held;
  for (std::size_t i = 0; i < flat.size(); i += 3) held.push_back({flat[i], flat[i + 1], flat[i + 2]});
  return held;
}

SectorCoordinates::SectorCoordinates(const CyclicSector &sector, PetscInt held, int index) {
  const Value ahead = phase_of(index, sector.sectors);
  const std::vector<PetscInt> carrying = carriers(sector);
  contact_ = 3 * static_cast<int>(sector.contacts.size());
  int faces = 0, pairs = 0, nodes = 0;
  for (const CyclicSector::FaceNode &node : sector.faces) faces += static_cast<int>(node.left.size());
  for (const CyclicSector::Contact &contact : sector.contacts)
    pairs += contact.is_pair() ? 3 : 0, nodes += contact.is_pair() ? 6 : 3;
  const int carried = static_cast<int>(carrying.size()), rest = static_cast<int>(held) - nodes - carried - 2 * faces;
  own_ = pairs + carried + faces + rest;
  int s = 0, x = own_;
  for (const CyclicSector::Contact &contact : sector.contacts) {
    const double half = contact.is_pair() ? 0.5 : 1;
    const auto Q = [&](int d, int j) { return contact.axes[3 * j + d]; };
    const auto seen = [&](int d, int e) { // u_b' = seen u_b, exp(-i phi) R or 1
      return contact.next ? std::conj(ahead) * sector.turn[3 * d + e] : Value(d == e);
    };
    for (int d = 0; d < 3 && contact.has_a(); ++d) { // u_a = (s + Q x) / 2, or Q x + what it stands on
      rows_.emplace_back();
      if (contact.is_pair()) rows_.back().push_back({s + d, 0.5});
      for (int j = 0; j < 3; ++j)
        if (Q(d, j) != 0) rows_.back().push_back({x + j, half * Q(d, j)});
      for (const CyclicSector::Weighted &part : contact.face)
        for (int e = 0; e < 3; ++e)
          if (part.node[e] >= 0 && seen(d, e) != 0.0) {
            const auto place = std::lower_bound(carrying.begin(), carrying.end(), part.node[e]) - carrying.begin();
            rows_.back().push_back({pairs + static_cast<int>(place), part.weight * seen(d, e)});
          }
    }
    for (int d = 0; d < 3 && contact.has_b(); ++d) { // u_b' = (s - Q x) / 2, or - Q x
      rows_.emplace_back();
      for (int e = 0; e < 3; ++e) {
        const Value back = std::conj(seen(e, d));
        if (back == 0.0) continue;
        if (contact.is_pair()) rows_.back().push_back({s + e, 0.5 * back});
        for (int j = 0; j < 3; ++j) rows_.back().push_back({x + j, -half * back * Q(e, j)});
      }
    }
    s += contact.is_pair() ? 3 : 0, x += 3;
  }
  for (int i = 0; i < carried; ++i, ++s) rows_.push_back({{s, 1.0}});
  for (int i = 0; i < faces; ++i) rows_.push_back({{s + i, 1.0}});
  int first = s;                                            // of the node's own coordinates
  for (const CyclicSector::FaceNode &node : sector.faces) { // u_R = exp(-i phi) R u_L
    const int count = static_cast<int>(node.direction.size());
    for (const int i : node.direction) {
      rows_.emplace_back();
      for (int j = 0; j < count; ++j)
        if (const int from = node.direction[j]; i / 3 == from / 3 && sector.turn[3 * (i % 3) + from % 3] != 0)
          rows_.back().push_back({first + j, std::conj(ahead) * sector.turn[3 * (i % 3) + from % 3]});
    }
    first += count;
  }
  for (int i = 0; i < rest; ++i) rows_.push_back({{s + faces + i, 1.0}});
}

int SectorCoordinates::contact_at(int i) const {
  if (rows_[i].size() != 1) return -1;
  const Entry &entry = rows_[i].front();
  return entry.value == 1.0 && entry.column >= own_ ? entry.column - own_ : -1;
}

ComplexDense SectorCoordinates::to_held(const ComplexDense &y) const {
  ComplexDense out(held(), y.columns);
  for (int column = 0; column < y.columns; ++column)
    for (int i = 0; i < held(); ++i)
      for (const Entry &entry : rows_[i])
        if (entry.column < y.rows) out(i, column) += entry.value * y(entry.column, column);
  return out;
}

ComplexDense SectorCoordinates::own_from_held(const ComplexDense &b) const {
  ComplexDense out(own_, b.columns);
  for (int column = 0; column < b.columns; ++column)
    for (int i = 0; i < held(); ++i)
      for (const Entry &entry : rows_[i])
        if (entry.column < own_) out(entry.column, column) += std::conj(entry.value) * b(i, column);
  return out;
}

ComplexDense SectorCoordinates::from_held(const double *values, int columns) const {
  ComplexDense out(all(), columns);
  for (int i = 0; i < held(); ++i)
    for (const Entry &entry : rows_[i])
      for (int column = 0; column < columns; ++column)
        out(entry.column, column) += std::conj(entry.value) * values[static_cast<std::size_t>(i) * columns + column];
  return out;
}

ComplexDense SectorCoordinates::congruent(const std::vector<double> &symmetric) const {
  const int n = held();
  ComplexDense half(n, all()), out(all(), all()); // A E, then E^H of it
  for (int j = 0; j < n; ++j)
    for (const Entry &entry : rows_[j])
      for (int i = 0; i < n; ++i) half(i, entry.column) += symmetric[static_cast<std::size_t>(j) * n + i] * entry.value;
  for (int column = 0; column < all(); ++column)
    for (int i = 0; i < n; ++i)
      for (const Entry &entry : rows_[i]) out(entry.column, column) += std::conj(entry.value) * half(i, column);
  return out;
}

} // namespace dovetail
