#pragma once
// What a model file says of its nodes and of the dofs that move them; each is checked as it is read.
#include <string>
#include <vector>

#include "support/hdf5.hpp"

namespace dovetail {

/// Number of nodes. InputError where there is no mesh: "`where`: ... has no mesh, so that nodes cannot be named;
/// `instead`".
long nodes_of(const h5::Reader &file, const std::string &where, const std::string &instead);

/// The dofs that joints have changed: dof[i] is the sum of value[j] times dof column[j], j = begin[i] .. begin[i + 1].
struct ChangedDofs {
  std::vector<long> dof, begin, column;
  std::vector<double> value;
};
/// Of a model with n dofs; empty where no joint has changed any.
ChangedDofs changed_dofs(const h5::Reader &file, long n);

} // namespace dovetail
