#include "results/gather.hpp"

#include <algorithm>
#include <cmath>

#include "results/results_file.hpp"
#include "support/error.hpp"
#include "support/gathered.hpp"
#include "support/hdf5.hpp"

namespace dovetail {

std::vector<double> gather(MPI_Comm comm, const std::vector<double> &own) { return gathered(comm, MPI_DOUBLE, own, 0); }

void check_start(const std::filesystem::path &results, PetscInt dofs, const TravellingWave &wave) {
  const h5::Reader file(results);
  check_format(file);
  const std::string name = "/points/coefficients";
  const auto shape = file.extent(name);
  if (shape.size() != 3 || shape[1] != static_cast<hsize_t>(dofs))
    throw InputError(file.place(name) + ": does not belong to this model, which has " + std::to_string(dofs) +
                     " reduced dofs (N_a + 3 N_x); continuation.start wants results of the same reduction");
  const auto frequencies = file.extent("/points/omega");
  if (shape[0] == 0 || frequencies.size() != 1 || frequencies[0] == 0)
    throw InputError(file.place("/points/omega") + ": holds no point to start from");
  const long sectors = file.integer_attribute("sectors", 0), order = file.integer_attribute("engine_order", 0);
  const auto in_words = [](long n, long eo) {
    return n == 0 ? std::string("no cyclic structure")
                  : std::to_string(n) + " sectors, engine order " + std::to_string(eo);
  };
  if (sectors != wave.sectors || order != wave.engine_order)
    throw InputError(results.string() + ": are results of " + in_words(sectors, order) + "; continuation.start wants " +
                     in_words(wave.sectors, wave.engine_order));
}

void start_from(const std::filesystem::path &results, double omega, const Layout &layout, const Scales &scales, Vec y) {
  std::vector<double> modal, contact;
  hsize_t width = 0;
  on_all_ranks(layout.comm, [&] {
    const h5::Reader file(results);
    const std::string name = "/points/coefficients";
    const auto shape = file.extent(name);
    const auto frequencies = file.doubles("/points/omega");
    const auto nearest =
        std::min_element(frequencies.begin(), frequencies.begin() + std::min<hsize_t>(shape[0], frequencies.size()),
                         [&](double a, double b) { return std::abs(a - omega) < std::abs(b - omega); });
    const hsize_t point = nearest - frequencies.begin();
    width = shape[2];
    const hsize_t first_mode = layout.own_modes.begin, modes = layout.own_modes.size();
    const hsize_t first_contact = layout.modes + 3 * layout.own_points.begin, contacts = 3 * layout.own_points.size();
    modal = file.doubles(name, {point, first_mode, 0}, {1, modes, width});
    contact = file.doubles(name, {point, first_contact, 0}, {1, contacts, width});
    for (const auto *own : {&modal, &contact})
      if (!std::all_of(own->begin(), own->end(), [](double value) { return std::isfinite(value); }))
        throw InputError(file.place(name) + ": the point to start from, number " + std::to_string(point) +
                         " (of 0..), is not finite");
  });
  double *values;
  check(VecGetArray(y, &values), "starting from results");
  const auto fill = [&](const std::vector<double> &from, double scale, PetscInt dofs, double *to) {
    for (PetscInt d = 0; d < dofs; ++d)
      for (int i = 0; i < std::min<int>(layout.width, static_cast<int>(width)); ++i)
        to[d * layout.width + i] = from[d * width + i] / scale;
  };
  fill(modal, scales.modal, layout.own_modes.size(), values);
  fill(contact, scales.contact, 3 * layout.own_points.size(), values + layout.own_modes.size() * layout.width);
  check(VecRestoreArray(y, &values), "starting from results");
}

} // namespace dovetail
