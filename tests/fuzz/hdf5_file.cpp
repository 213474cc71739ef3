// Any bytes as an HDF5 file: as a full model, as a reduced one, as one to be replaced, and as results to start from.
#include <petscsys.h>

#include "harness.hpp"
#include "model/full_model.hpp"
#include "reduction/reduced_model.hpp"
#include "results/gather.hpp"
#include "support/hdf5.hpp"

using namespace dovetail;

namespace {

void as_model(const std::filesystem::path &file) {
  fuzz::taken(file, [&] { read_model_header(file); });
  fuzz::taken(file, [&] { motion_dofs(file, {true, false, {"tip"}, {0, 1}, "case.toml:3: output.motion"}); });
  fuzz::taken(file, [&] { read_full_model(MPI_COMM_SELF, file); });
}

void as_reduced(const std::filesystem::path &file) {
  fuzz::taken(file, [&] { read_reduced(MPI_COMM_SELF, file); });
  fuzz::taken(file, [&] { check_replaceable(file); });
  matches(MPI_COMM_SELF, file, {});
}

void as_start(const std::filesystem::path &file) {
  ReducedModel model; // two modes, one contact point, one harmonic
  model.comm = MPI_COMM_SELF, model.modes = 2, model.points = 1;
  model.own_modes = {0, 2}, model.own_points = {0, 1};
  const Layout layout(model, 1);
  UniqueVec y;
  check(VecCreateSeq(MPI_COMM_SELF, layout.unknowns(), y.out()), "creating a vector");
  fuzz::taken(file, [&] {
    check_start(file, layout.dofs(), {});
    start_from(file, 1.0, layout, {}, y);
  });
}

} // namespace

extern "C" int LLVMFuzzerInitialize(int *, char ***) {
  PetscInitializeNoArguments();
  install_error_handler();
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t *data, std::size_t size) {
  static const fuzz::Scratch folder;
  const auto file = folder / "file.h5";
  fuzz::write(file, data, size);
  for (const auto read : {as_model, as_reduced, as_start}) read(file);
  H5close(); // an InputError leaves files open (h5::Id), which only matters to a process that meets thousands
  return 0;
}
