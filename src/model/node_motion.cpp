// The motion of a node or node set in terms of the dofs of the model: u = T q where joints have changed them.
#include <algorithm>
#include <map>
#include <set>

#include "model/full_model.hpp"
#include "support/error.hpp"
#include "support/hdf5.hpp"

namespace dovetail {
namespace {

// Adds row i of T, times a factor.
void add_row_of_T(const h5::Reader &file, const std::vector<long> &begin, std::size_t i, double factor,
                  std::map<PetscInt, double> &sum) {
  if (i + 1 >= begin.size() || begin[i] < 0 || begin[i] > begin[i + 1])
    throw InputError(file.place("/mesh/changed") + ": entry " + std::to_string(i) + " is out of range");
  const h5::Extent first{hsize_t(begin[i])}, count{hsize_t(begin[i + 1] - begin[i])};
  const auto columns = file.integers("/mesh/changed/column", first, count);
  const auto values = file.doubles("/mesh/changed/value", first, count);
  for (std::size_t j = 0; j < columns.size(); ++j) sum[static_cast<PetscInt>(columns[j])] += factor * values[j];
}

} // namespace

NodeMotion node_motion(const std::filesystem::path &path, const Watch &watch) {
  const h5::Reader file(path);
  const std::string said = watch.where + " = \"" + watch.name + "\": ";
  if (!file.has("/mesh/dof_node"))
    throw InputError(said + path.string() + " has no mesh (/mesh/dof_node), so that nodes cannot be named; name an " +
                     "unknown such as \"x1.t1\"");
  const auto places = file.extent("/mesh/nodes");
  if (places.size() != 2) throw InputError(file.place("/mesh/nodes") + ": one row of x, y, z per node is wanted");
  const long nodes = static_cast<long>(places[0]);
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
  std::map<long, std::size_t> changed;
  std::vector<long> begin;
  if (file.has("/mesh/changed/dof")) {
    const auto dofs = file.integers("/mesh/changed/dof");
    begin = file.integers("/mesh/changed/begin");
    for (std::size_t i = 0; i < dofs.size(); ++i) changed[dofs[i]] = i;
  }
  const double share = 1.0 / wanted.size();
  std::map<PetscInt, double> sum;
  for (std::size_t dof = 0; dof < dof_node.size(); ++dof) {
    if (direction[dof] != watch.direction || wanted.count(dof_node[dof]) == 0) continue;
    if (const auto found = changed.find(static_cast<long>(dof)); found != changed.end())
      add_row_of_T(file, begin, found->second, share, sum);
    else
      sum[static_cast<PetscInt>(dof)] += share;
  }
  NodeMotion motion;
  for (const auto &[dof, factor] : sum) {
    if (dof < 0 || dof >= static_cast<PetscInt>(dof_node.size()))
      throw InputError(file.place("/mesh/changed/column") + ": " + std::to_string(dof) + " is out of range");
    if (factor != 0) motion.dofs.push_back(dof), motion.factors.push_back(factor);
  }
  if (motion.dofs.empty())
    throw InputError(said + "\"" + watch.node + "\" does not move along " +
                     std::string(1, char('x' + watch.direction)) +
                     ": it is held there, or has no such degree of freedom");
  return motion;
}

} // namespace dovetail
