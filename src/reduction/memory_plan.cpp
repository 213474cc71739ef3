#include "reduction/memory_plan.hpp"

#include <algorithm>
#include <cstdio>
#include <utility>

#include "reduction/elastic_modes.hpp"
#include "support/error.hpp"
#include "support/memory.hpp"

namespace dovetail {
namespace {

constexpr double gib = 1024.0 * 1024 * 1024;

std::string gibibytes(double bytes) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g GiB", bytes / gib);
  return text;
}

// A block of n right-hand sides: what MUMPS works on and, on several ranks, the solution as MUMPS lays it out.
double solving(double rows, double n, bool alone) { return rows * n * (alone ? 8 : 8 + 8); }

} // namespace

MemoryPlan plan_memory(const ClampedStructure &parts, PetscInt modes, PetscInt kept_rows, double limit,
                       bool count_modes) {
  const MPI_Comm comm = parts.full.comm;
  int ranks;
  MPI_Comm_size(comm, &ranks);
  const bool alone = ranks == 1;
  const double rows = parts.own.size(), nc = 3.0 * parts.full.contact_dofs.size(),
               own_nc = 3.0 * parts.own_points.size(), wanted = std::max<PetscInt>(modes, 1), b = lanczos_block,
               damped = (parts.C.cc ? 1 : 0) + (parts.K_structural.cc ? 1 : 0); // matrices of damping
  const double now = resident_bytes(), factor = parts.solver ? parts.solver->forecast_bytes() : 0;
  const double basis = lanczos_columns(static_cast<PetscInt>(wanted), parts.elastic) + 3 * b;
  const double reduced = 8 * (own_nc * ((2 + damped) * nc + (1 + damped) * modes) + damped * modes * modes);
  const double search = 8 * rows * (basis + wanted + 8 * b) + solving(rows, b, alone) + 3 * 8 * basis * basis + reduced;
  const double kept = reduced + 8.0 * kept_rows * (nc + modes) + 8 * rows * modes;
  double counting = 0; // a second factorisation, with pivoting and PETSc's copies, when Psi is gone
  if (count_modes && parts.solver) {
    MatInfo info{};
    check(MatGetInfo(parts.K.ee, MAT_LOCAL, &info), "planning memory");
    counting = kept + 1.6 / 1.2 * factor + (12 + 8) * info.nz_used;
  }

  MemoryPlan plan;
  const double used = sum_on_machine(comm, now), available = available_bytes();
  double room = limit > 0 ? limit : used + available;
  MPI_Allreduce(MPI_IN_PLACE, &room, 1, MPI_DOUBLE, MPI_MIN, comm);
  plan.room_bytes = room;
  const std::pair<bool, PetscInt> choices[] = {
      {true, 256}, {true, 64}, {false, 128}, {false, 32}}; // from fast to small
  for (const auto &[keep, block] : choices) {
    const double n = std::min<double>(block, nc);
    const double psi = 8 * rows * (keep ? nc : n + n); // without Psi the second solution takes its place
    plan.keep_psi = keep, plan.block = block;
    const double solves = kept + psi + 8 * rows * (n + b) + solving(rows, n, alone) + 2 * 8 * nc * n;
    plan.bytes = now + std::max(factor + std::max(search, solves), counting);
    plan.machine_bytes = sum_on_machine(comm, plan.bytes);
    MPI_Allreduce(MPI_IN_PLACE, &plan.machine_bytes, 1, MPI_DOUBLE, MPI_MAX, comm);
    if (plan.machine_bytes <= room) break;
  }
  MPI_Allreduce(&plan.bytes, &plan.total_bytes, 1, MPI_DOUBLE, MPI_SUM, comm);
  return plan;
}

void refuse_if_too_large(const ClampedStructure &parts, const MemoryPlan &plan) {
  if (plan.machine_bytes <= plan.room_bytes) return;
  int ranks;
  MPI_Comm_size(parts.full.comm, &ranks);
  const bool whole = ranks > 1 && parts.solver && !parts.solver->shared();
  double factor = parts.solver ? parts.solver->forecast_bytes() : 0;
  MPI_Allreduce(MPI_IN_PLACE, &factor, 1, MPI_DOUBLE, MPI_SUM, parts.full.comm);
  throw ComputeError(
      parts.full.file.string() + ": the reduction would take " + gibibytes(plan.machine_bytes) +
      " on a machine that has " + gibibytes(plan.room_bytes) + " for it (" + gibibytes(factor) +
      " of it for the factors of K_ee). " +
      (whole ? "Let the ranks share one factor (-kee_whole false; last bits then differ from run to run), take"
             : "Take") +
      " ranks on more machines, keep the factors on disk "
      "(-kee_mat_mumps_icntl_22 1, with room where MUMPS_OOC_TMPDIR points), take fewer contact points or modes, or "
      "raise reduction.memory if it is set.");
}

std::string in_words(const MemoryPlan &plan) {
  return gibibytes(plan.total_bytes) + " over all ranks, " + gibibytes(plan.machine_bytes) + " of " +
         gibibytes(plan.room_bytes) + " on the fullest machine" +
         (plan.keep_psi ? "" : "; too little to keep Psi, which is computed a block at a time with twice the solves");
}

} // namespace dovetail
