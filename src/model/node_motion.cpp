// The motion of a node or node set in terms of the dofs of the model: u = T q where joints have changed them.
#include <algorithm>
#include <map>
#include <set>

#include "model/full_model.hpp"
#include "model/mesh_dofs.hpp"
#include "support/error.hpp"
#include "support/hdf5.hpp"

namespace dovetail {
NodeMotion node_motion(const std::filesystem::path &path, const Watch &watch) {
  const h5::Reader file(path);
  const std::string said = watch.where + " = \"" + watch.name + "\": ";
  const long nodes = nodes_of(file, watch.where + " = \"" + watch.name + "\"", "name an unknown such as \"x1.t1\"");
  const bool number = watch.node.size() < 10 && std::all_of(watch.node.begin(), watch.node.end(),
                                                            [](unsigned char c) { return std::isdigit(c) != 0; });
  std::set<long> wanted;
  if (file.has("/mesh/sets/" + watch.node)) {
    const auto members = file.integers("/mesh/sets/" + watch.node);
    wanted.insert(members.begin(), members.end());
  } else if (number && std::stol(watch.node) < nodes) {
    wanted.insert(std::stol(watch.node));
  } else {
    throw InputError(said + "there is no node set or node \"" + watch.node + "\" in " + path.string() +
                     ", whose nodes are 0.." + std::to_string(nodes - 1) +
                     " (groups and datasets under /mesh/sets are its sets)");
  }
  const auto dof_node = file.integers("/mesh/dof_node"), direction = file.integers("/mesh/dof_direction");
  if (direction.size() != dof_node.size())
    throw InputError(file.place("/mesh/dof_direction") + ": as many as /mesh/dof_node are wanted");
  const ChangedDofs changed = changed_dofs(file, static_cast<long>(dof_node.size()));
  std::map<long, std::size_t> row; // of T, of each changed dof
  for (std::size_t i = 0; i < changed.dof.size(); ++i) row[changed.dof[i]] = i;
  const double share = 1.0 / wanted.size();
  std::map<PetscInt, double> sum;
  for (std::size_t dof = 0; dof < dof_node.size(); ++dof) {
    if (direction[dof] != watch.direction || wanted.count(dof_node[dof]) == 0) continue;
    const auto found = row.find(static_cast<long>(dof));
    if (found == row.end()) {
      sum[static_cast<PetscInt>(dof)] += share;
      continue;
    }
    for (long j = changed.begin[found->second]; j < changed.begin[found->second + 1]; ++j)
      sum[static_cast<PetscInt>(changed.column[j])] += share * changed.value[j];
  }
  NodeMotion motion;
  for (const auto &[dof, factor] : sum)
    if (factor != 0) motion.dofs.push_back(dof), motion.factors.push_back(factor);
  if (motion.dofs.empty())
    throw InputError(said + "\"" + watch.node + "\" does not move along " +
                     std::string(1, char('x' + watch.direction)) +
                     ": it is held there, or has no such degree of freedom");
  return motion;
}

} // namespace dovetail
