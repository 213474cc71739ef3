#include <algorithm>
#include <set>

#include "model/full_model.hpp"
#include "model/mesh_dofs.hpp"
#include "support/error.hpp"
#include "support/hdf5.hpp"

namespace dovetail {

std::vector<PetscInt> motion_dofs(const std::filesystem::path &path, const MotionWish &wish) {
  if (wish.sets.empty() && wish.nodes.empty()) return {};
  const h5::Reader file(path);
  const long nodes = nodes_of(file, wish.where, "write \"all\" or []");
  const auto dof_node = file.integers("/mesh/dof_node");
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
  const ChangedDofs changed = changed_dofs(file, static_cast<long>(marked.size())); // move with what they are made of
  const std::vector<char> before = marked;
  for (std::size_t i = 0; i < changed.dof.size(); ++i)
    for (long at = changed.begin[i]; before[changed.dof[i]] && at < changed.begin[i + 1]; ++at)
      marked[changed.column[at]] = 1;
  std::vector<PetscInt> dofs;
  for (std::size_t dof = 0; dof < marked.size(); ++dof)
    if (marked[dof]) dofs.push_back(static_cast<PetscInt>(dof));
  return dofs;
}

} // namespace dovetail
