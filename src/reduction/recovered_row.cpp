// A row of Phi and Psi, put together for the motion of a node.
#include <algorithm>
#include <map>

#include "reduction/reduced_model.hpp"
#include "support/error.hpp"
#include "support/hdf5.hpp"

namespace dovetail {

std::vector<double> recovered_row(const std::filesystem::path &path, const std::vector<PetscInt> &dofs,
                                  const std::vector<double> &factors) {
  const h5::Reader file(path);
  const auto contact = file.integers("/recovery/contact_dofs"), elastic = file.integers("/recovery/elastic_dofs");
  const hsize_t modes = file.extent("/Kaa")[0], columns = contact.size();
  std::map<long, hsize_t> place_of_contact, place_of_elastic;
  for (hsize_t i = 0; i < contact.size(); ++i) place_of_contact[contact[i]] = i;
  for (hsize_t i = 0; i < elastic.size(); ++i)
    if (std::binary_search(dofs.begin(), dofs.end(), elastic[i])) place_of_elastic[elastic[i]] = i;
  std::vector<double> row(modes + columns, 0.0);
  for (std::size_t k = 0; k < dofs.size(); ++k) {
    if (const auto found = place_of_contact.find(dofs[k]); found != place_of_contact.end()) {
      row[modes + found->second] += factors[k];
      continue;
    }
    const auto found = place_of_elastic.find(dofs[k]);
    if (found == place_of_elastic.end())
      throw InputError(path.string() + ": does not keep the motion of dof " + std::to_string(dofs[k]) +
                       ", which continuation.watch asks for; remove the file, it will be made anew");
    std::vector<double> parts =
        modes > 0 ? file.doubles("/recovery/Phi", {found->second, 0}, {1, modes}) : std::vector<double>();
    const auto psi = file.doubles("/recovery/Psi", {found->second, 0}, {1, columns});
    parts.insert(parts.end(), psi.begin(), psi.end());
    for (std::size_t i = 0; i < parts.size(); ++i) row[i] += factors[k] * parts[i];
  }
  return row;
}

} // namespace dovetail
