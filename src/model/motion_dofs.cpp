#include <algorithm>
#include <set>

#include "model/full_model.hpp"
#include "support/error.hpp"
#include "support/hdf5.hpp"

namespace dovetail {

std::vector<PetscInt> motion_dofs(const std::filesystem::path &path, const MotionWish &wish) {
  if (wish.sets.empty() && wish.nodes.empty()) return {};
  const h5::Reader file(path);
  if (!file.has("/mesh/dof_node"))
    throw InputError(wish.where + ": " + path.string() +
                     " has no mesh (/mesh/dof_node), so that nodes cannot be named; "
                     "write \"all\" or []");
  const auto dof_node = file.integers("/mesh/dof_node");
  const auto places = file.extent("/mesh/nodes");
  if (places.size() != 2) throw InputError(file.place("/mesh/nodes") + ": one row of x, y, z per node is wanted");
  const long nodes = static_cast<long>(places[0]);
  std::set<long> wanted;
  for (const long node : wish.nodes) {
    if (node >= nodes)
      throw InputError(wish.where + ": node " + std::to_string(node) + " is not in " + path.string() +
                       ", whose nodes are 0.." + std::to_string(nodes - 1));
    wanted.insert(node);
  }
  for (const auto &name : wish.sets) {
    if (!file.has("/mesh/sets/" + name))
      throw InputError(wish.where + ": there is no node set \"" + name + "\" in " + path.string() +
                       " (groups and datasets under /mesh/sets are)");
    const auto members = file.integers("/mesh/sets/" + name);
    wanted.insert(members.begin(), members.end());
  }
  std::vector<char> marked(dof_node.size(), 0);
  for (std::size_t dof = 0; dof < dof_node.size(); ++dof) marked[dof] = wanted.count(dof_node[dof]) > 0;
  if (file.has("/mesh/changed/dof")) { // these move with the dofs they are made of
    const auto dofs = file.integers("/mesh/changed/dof"), begin = file.integers("/mesh/changed/begin"),
               columns = file.integers("/mesh/changed/column");
    const auto n = static_cast<long>(marked.size());
    if (begin.size() != dofs.size() + 1 || begin.back() != static_cast<long>(columns.size()))
      throw InputError(file.place("/mesh/changed") + ": dof, begin and column do not fit together");
    std::vector<char> before = marked;
    for (std::size_t i = 0; i < dofs.size(); ++i) {
      if (dofs[i] < 0 || dofs[i] >= n || begin[i] < 0 || begin[i] > begin[i + 1] || begin[i + 1] > begin.back())
        throw InputError(file.place("/mesh/changed") + ": entry " + std::to_string(i) + " is out of range");
      if (!before[dofs[i]]) continue;
      for (long at = begin[i]; at < begin[i + 1]; ++at) {
        if (columns[at] < 0 || columns[at] >= n)
          throw InputError(file.place("/mesh/changed/column") + ": " + std::to_string(columns[at]) +
                           " is out of range");
        marked[columns[at]] = 1;
      }
    }
  }
  std::vector<PetscInt> dofs;
  for (std::size_t dof = 0; dof < marked.size(); ++dof)
    if (marked[dof]) dofs.push_back(static_cast<PetscInt>(dof));
  return dofs;
}

} // namespace dovetail
