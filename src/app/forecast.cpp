#include "app/forecast.hpp"

#include <algorithm>
#include <cstdio>
#include <ostream>
#include <set>

#include "case/travelling_wave.hpp"
#include "contact/linearisation.hpp"
#include "stuck/near_basis.hpp"
#include "support/error.hpp"
#include "support/memory.hpp"

namespace dovetail {
namespace {

constexpr double gib = 1024.0 * 1024 * 1024;

// Bytes of one system in the stuck modes beyond the matrices: blocks of the contacts, vectors of GMRES, and factors of
// the points that move, as many as may be (modal_solver.hpp).
double beyond_matrices(double dofs, double points, double harmonics) {
  const double n = 2 * harmonics + 1, factored = std::min(3 * points * n, 4000.0);
  return 28 * points * n * n + 8 * 62 * dofs * n + 12 * factored * factored + 24 * n * factored;
}

// K and M by rows, and what the modes take at most while they are found: four matrices and the work of their
// eigenproblem, or where it is not solved the factor that stands for it.
double dense_matrices(double dofs, double contact_dofs, bool dampers) {
  const bool near = dofs >= many_dofs && !dampers;
  return 8 * contact_dofs * (dofs + contact_dofs) + (near ? 8 : 60) * dofs * dofs;
}

// The same of a sector beyond its real index: the reduced model in every index, and what complex numbers take for each
// |h| that harmonics up to `highest` have; and their eigenproblems, one on each rank at a time, here on one.
double sector_matrices(double dofs, double contact_dofs, const TravellingWave &wave, int highest) {
  std::set<int> indices;
  for (int k = 1; k <= highest; ++k) indices.insert(std::abs(wave.index(k)));
  indices.erase(0);
  const double reduced = 16 * contact_dofs * (dofs + contact_dofs), of_index = 2 * reduced + 24 * dofs * dofs;
  return reduced * (wave.sectors / 2) + of_index * static_cast<double>(indices.size()) + 64 * dofs * dofs;
}

// K_xx once more, and factors of two stiffnesses of the joint, where the preload is solved anew along a path.
double preload_matrices(double contact_dofs) { return 24 * contact_dofs * contact_dofs; }

// K and M of the assembled form by pair of dofs: as a list, and of a sector by every index and spread over harmonics.
double matrix_bytes(double harmonics, int sectors) {
  return sectors == 0 ? 40 : 48 * (1 + sectors / 2) + 2 * 36 * (1 + 4 * harmonics);
}

struct AssembledSize {
  double entries, bytes;
};

// `blocks`: of the contact laws; the pattern of K_xx has 1 + 4H entries of each already.
AssembledSize assembled(double modes, double contact_dofs, double harmonics, double blocks, int sectors) {
  const double n = 2 * harmonics + 1, unknowns = (modes + contact_dofs) * n + 1, mixed = 2 * modes * contact_dofs;
  const double pairs = contact_dofs * contact_dofs + modes; // with stiffness; modes and contact meet in the mass only
  const double entries = pairs * (1 + 4 * harmonics) + mixed * (sectors == 0 ? 2 : 4) * harmonics +
                         blocks * (n * n - 1 - 4 * harmonics) + 2 * unknowns;
  // 12 bytes an entry in the matrix, 24 in the list it is assembled from; the factors at worst full
  const double factor = std::min(unknowns * unknowns, 20 * entries);
  const double matrices = matrix_bytes(harmonics, sectors) * (sectors == 0 ? pairs : pairs + mixed);
  return {entries, 36 * entries + 12 * factor + matrices};
}

void harmonic_balance(Forecast &sizes, const Case &study, int sectors) {
  const double h = study.harmonics, n = 2 * h + 1, na = sizes.modes, nc = 3.0 * sizes.points;
  sizes.unknowns = (na + nc) * n + 1;
  if (study.range().parameter->changes_joint) sizes.solve_gib += preload_matrices(nc) / gib;
  const bool peaks = study.follows_peaks(); // their track is always of the assembled form
  if (study.solver == SolverKind::modal) {
    const int finer = study.estimates ? std::max(2 * study.harmonics, study.harmonics + 2) : study.harmonics,
              highest = study.tolerance > 0 ? sectors : finer; // with a tolerance all there may be
    const TravellingWave wave = study.wave(sectors);
    sizes.solve_gib +=
        (dense_matrices(na + nc, nc, study.damping.has_dampers() || study.damping.has_stuck_ratios()) +
         (sectors > 0 ? sector_matrices(na + nc, nc, wave, highest) : 0) + beyond_matrices(na + nc, sizes.points, h) +
         (study.estimates ? beyond_matrices(na + nc, sizes.points, 2 * h) : 0)) /
        gib;
    if (!peaks) return;
  }
  double blocks = 0; // of the contact laws
  const auto &laws = study.contact.law.values;
  for (PetscInt p = 0; p < sizes.points; ++p) // their number is checked after this
    blocks += block_places(laws[std::min<std::size_t>(p, laws.size() - 1)]).size();
  const AssembledSize one = assembled(na, nc, h, blocks, sectors);
  const int systems =
      peaks && study.solver == SolverKind::assembled ? 2 : 1; // the response's own, and that of the track
  sizes.jacobian_entries = one.entries, sizes.solve_gib += systems * one.bytes / gib;
  if (sectors > 0 && study.estimates && study.solver == SolverKind::assembled)
    sizes.solve_gib += assembled(na, nc, 2 * h, blocks, sectors).bytes / gib;
}

} // namespace

Forecast forecast(const ModelHeader &header, const Case &study) {
  Forecast sizes;
  sizes.dofs = header.dofs, sizes.nonzeros = header.nonzeros, sizes.modes = study.modes, sizes.points = header.points;
  harmonic_balance(sizes, study, header.sectors);
  return sizes;
}

Forecast forecast(const ReducedHeader &header, const Case &study) {
  Forecast sizes;
  sizes.modes = header.modes, sizes.points = header.points;
  harmonic_balance(sizes, study, header.sectors);
  return sizes;
}

void describe(std::ostream &out, const Forecast &sizes) {
  char line[200];
  out << "\nsizes\n";
  if (sizes.dofs > 0) {
    std::snprintf(line, sizeof line, "  full model               %ld dofs, %.4g entries in K\n", long(sizes.dofs),
                  sizes.nonzeros);
    out << line;
  }
  std::snprintf(line, sizeof line, "  reduced model            %ld modes, %ld contact points\n", long(sizes.modes),
                long(sizes.points));
  out << line;
  std::snprintf(line, sizeof line, "  harmonic balance         %.0f unknowns", sizes.unknowns);
  out << line;
  if (sizes.jacobian_entries > 0) {
    std::snprintf(line, sizeof line, ", %.3g Jacobian entries", sizes.jacobian_entries);
    out << line;
  }
  out << '\n';
  std::snprintf(line, sizeof line, "memory\n  harmonic balance         roughly %.2g GiB over all ranks\n",
                sizes.solve_gib);
  out << line;
}

void check_memory(MPI_Comm comm, const Forecast &sizes, const std::string &who, const std::string &less) {
  int ranks;
  MPI_Comm_size(comm, &ranks);
  const double wanted = sum_on_machine(comm, sizes.solve_gib / ranks), free = available_bytes() / gib;
  double short_of[] = {wanted > free ? 1.0 : 0.0, wanted > free ? wanted : 0, wanted > free ? free : 0};
  MPI_Allreduce(MPI_IN_PLACE, short_of, 3, MPI_DOUBLE, MPI_MAX, comm);
  if (short_of[0] == 0) return;
  char text[160];
  std::snprintf(text, sizeof text,
                " of %.0f unknowns as a whole, roughly %.2g GiB on one machine, where %.2g GiB are free; ",
                sizes.unknowns, short_of[1], short_of[2]);
  throw ComputeError(who + text + less);
}

} // namespace dovetail
