#pragma once
// The own rows of K and M of a reduced model, wherever they are kept: the model's own, or slabs made of them.
#include <cstddef>
#include <filesystem>
#include <vector>

#include "reduction/reduced_model.hpp"

namespace dovetail {

struct PencilRows {
  struct Rows { // of the own contact dofs
    const double *first = nullptr;
    std::size_t stride = 0;
    const double *row(std::size_t i) const { return first + i * stride; }
  };
  std::vector<double> kaa;                ///< (N_a) on every rank
  Rows kxx, mxx, mxa;                     ///< of 3 N_x, 3 N_x and N_a numbers; they must outlive this
  std::filesystem::path file, stuck_file; ///< as of ReducedModel

  /// Those that the model holds.
  PencilRows(const ReducedModel &model)
      : kaa(model.kaa), kxx(rows(model.kxx, model.contact_dofs())), mxx(rows(model.mxx, model.contact_dofs())),
        mxa(rows(model.mxa, model.modes)), file(model.file), stuck_file(model.stuck_file) {}
  PencilRows(const ReducedModel &model, Rows stiffness, Rows mass, Rows coupling)
      : kaa(model.kaa), kxx(stiffness), mxx(mass), mxa(coupling), file(model.file), stuck_file(model.stuck_file) {}

private:
  static Rows rows(const std::vector<double> &of, PetscInt length) {
    return {of.data(), static_cast<std::size_t>(length)};
  }
};

} // namespace dovetail
