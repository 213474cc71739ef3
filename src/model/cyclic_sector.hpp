#pragma once
// What a model file says of the cyclic structure whose sector it holds: group /cyclic, and contact points by nodes.
#include <array>
#include <cstdint>
#include <vector>

#include <petscsys.h>

#include "support/hdf5.hpp"

namespace dovetail {

struct CyclicSector {
  using Matrix = std::array<double, 9>; ///< (3, 3) row-major

  struct FaceNode { // a node of the left face and its partner, dof by dof
    std::vector<PetscInt> left, right;
    std::vector<int> direction; ///< 0 to 2 displacement along x, y, z, 3 to 5 rotation
  };
  using Node = std::array<PetscInt, 3>; ///< dofs along x, y, z, -1 where it is held
  struct Weighted {
    Node node;
    double weight; ///< of its shape function
  };
  struct Contact {
    Node a{-1, -1, -1}, b{-1, -1, -1}; ///< b by the node in this sector whose copy it is
    std::vector<Weighted> face;        ///< what a stands on where there is no b; nothing: the ground
    bool next = false;                 ///< b, or the face, belongs to the next sector
    Matrix axes{};                     ///< rows t1, t2, n

    bool has_a() const { return a[0] >= 0; }
    bool has_b() const { return b[0] >= 0; }
    bool is_pair() const { return has_a() && has_b(); }
  };

  int sectors = 0; ///< N; 0: the model is no sector
  Matrix turn{};   ///< R: by 2 pi / N about the axis, from one sector to the next
  std::vector<FaceNode> faces;
  std::vector<Contact> contacts;
  std::uint64_t hash = 0; ///< of all of it
};

/// Number of sectors of the whole, 0 if the model is no sector. InputError if it is below 2.
int sectors_of_model(const h5::Reader &file);

/// Number of contact points of a sector. InputError.
PetscInt sector_points(const h5::Reader &file);

/// Of a model with n dofs; nothing if it has no /cyclic. Each rank on its own. InputError.
CyclicSector read_cyclic_sector(const h5::Reader &file, PetscInt n);

} // namespace dovetail
