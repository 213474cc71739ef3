// A row of Phi and Psi, put together for the motion of a node.
#include <algorithm>
#include <map>
#include <string>

#include "reduction/reduced_model.hpp"
#include "support/error.hpp"
#include "support/hdf5.hpp"

namespace dovetail {

namespace {

// Rows of Phi and Psi, where their motion is kept.
std::map<PetscInt, hsize_t> kept_rows(const h5::Reader &file, const std::vector<PetscInt> &dofs) {
  const auto elastic = file.integers("/recovery/elastic_dofs");
  std::map<PetscInt, hsize_t> rows;
  for (hsize_t i = 0; i < elastic.size(); ++i)
    if (std::binary_search(dofs.begin(), dofs.end(), elastic[i])) rows[elastic[i]] = i;
  return rows;
}

hsize_t row_of(const std::map<PetscInt, hsize_t> &rows, PetscInt dof, const h5::Reader &file) {
  const auto found = rows.find(dof);
  if (found == rows.end())
    throw InputError(file.path().string() + ": does not keep the motion of dof " + std::to_string(dof) +
                     ", which continuation.watch asks for; remove the file, it will be made anew");
  return found->second;
}

// One row, with its entries, of `parts` numbers each, of both.
std::vector<double> entries(const h5::Reader &file, const std::string &group, hsize_t row, hsize_t parts) {
  std::vector<double> all;
  for (const char *name : {"Phi", "Psi"}) {
    const h5::Extent extent = file.extent(group + name);
    const auto some = parts == 1 ? file.doubles(group + name, {row, 0}, {1, extent[1]})
                                 : file.doubles(group + name, {row, 0, 0}, {1, extent[1], parts});
    all.insert(all.end(), some.begin(), some.end());
  }
  return all;
}

} // namespace

std::vector<double> recovered_row(const std::filesystem::path &path, const std::vector<PetscInt> &dofs,
                                  const std::vector<double> &factors) {
  const h5::Reader file(path);
  const auto contact = file.integers("/recovery/contact_dofs");
  const hsize_t modes = file.extent("/Kaa")[0], columns = contact.size();
  std::map<long, hsize_t> place_of_contact;
  for (hsize_t i = 0; i < contact.size(); ++i) place_of_contact[contact[i]] = i;
  const auto kept = kept_rows(file, dofs);
  std::vector<double> row(modes + columns, 0.0);
  for (std::size_t k = 0; k < dofs.size(); ++k) {
    if (const auto found = place_of_contact.find(dofs[k]); found != place_of_contact.end()) {
      row[modes + found->second] += factors[k];
      continue;
    }
    const std::vector<double> parts = entries(file, "/recovery/", row_of(kept, dofs[k], file), 1);
    for (std::size_t i = 0; i < parts.size(); ++i) row[i] += factors[k] * parts[i];
  }
  return row;
}

std::vector<std::vector<std::complex<double>>> recovered_rows(const std::filesystem::path &path, int sectors,
                                                              const std::vector<PetscInt> &dofs,
                                                              const std::vector<double> &factors) {
  const std::vector<double> first = recovered_row(path, dofs, factors);
  std::vector<std::vector<std::complex<double>>> rows{{first.begin(), first.end()}};
  const h5::Reader file(path);
  const auto kept = kept_rows(file, dofs);
  for (int h = 1; h <= sectors / 2; ++h) {
    auto &row = rows.emplace_back(first.size());
    for (std::size_t k = 0; k < dofs.size(); ++k) {
      const auto parts = entries(file, "/cyclic/" + std::to_string(h) + "/", row_of(kept, dofs[k], file), 2);
      for (std::size_t i = 0; i < row.size(); ++i)
        row[i] += factors[k] * std::complex<double>(parts[2 * i], parts[2 * i + 1]);
    }
  }
  return rows;
}

} // namespace dovetail
