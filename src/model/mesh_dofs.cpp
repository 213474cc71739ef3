#include "model/mesh_dofs.hpp"

#include "support/error.hpp"

namespace dovetail {

long nodes_of(const h5::Reader &file, const std::string &where, const std::string &instead) {
  if (!file.has("/mesh/dof_node"))
    throw InputError(where + ": " + file.path().string() +
                     " has no mesh (/mesh/dof_node), so that nodes cannot be named; " + instead);
  const auto places = file.extent("/mesh/nodes");
  if (places.size() != 2) throw InputError(file.place("/mesh/nodes") + ": one row of x, y, z per node is wanted");
  return static_cast<long>(places[0]);
}

ChangedDofs changed_dofs(const h5::Reader &file, long n) {
  ChangedDofs changed;
  if (!file.has("/mesh/changed/dof")) return changed;
  changed = {file.integers("/mesh/changed/dof"), file.integers("/mesh/changed/begin"),
             file.integers("/mesh/changed/column"), file.doubles("/mesh/changed/value")};
  const auto &[dof, begin, column, value] = changed;
  if (begin.size() != dof.size() + 1 || begin.back() != static_cast<long>(column.size()) ||
      value.size() != column.size())
    throw InputError(file.place("/mesh/changed") + ": dof, begin, column and value do not fit together");
  for (std::size_t i = 0; i < dof.size(); ++i)
    if (dof[i] < 0 || dof[i] >= n || begin[i] < 0 || begin[i] > begin[i + 1] || begin[i + 1] > begin.back())
      throw InputError(file.place("/mesh/changed") + ": entry " + std::to_string(i) + " is out of range");
  for (const long at : column)
    if (at < 0 || at >= n)
      throw InputError(file.place("/mesh/changed/column") + ": " + std::to_string(at) + " is out of range");
  return changed;
}

} // namespace dovetail
