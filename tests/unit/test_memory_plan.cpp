// What a reduction will take, by forecast, and what is done where that is too much. On any number of ranks.
#include <gtest/gtest.h>

#include <tuple>

#include "lattice_model.hpp"
#include "reduction/block_lanczos.hpp"
#include "reduction/sector_levels.hpp"
#include "support/error.hpp"
#include "support/memory.hpp"
#include "temporary_file.hpp"

using namespace dovetail;
using namespace dovetail::testing;

namespace {

int ranks() {
  int size;
  MPI_Comm_size(PETSC_COMM_WORLD, &size);
  return size;
}

} // namespace

namespace {

constexpr double rows = 1e9; // so many that no other vector counts

ClampedStructure parts_of(int points) {
  ClampedStructure parts;
  parts.full.comm = PETSC_COMM_WORLD, parts.full.file = "m.h5";
  parts.full.contact_dofs.resize(points);
  parts.own_points = own_share(PETSC_COMM_WORLD, points);
  parts.own = {0, static_cast<PetscInt>(rows)}, parts.elastic = static_cast<PetscInt>(rows);
  return parts;
}

double solving(double columns) { return columns * (ranks() == 1 ? 8 : 16); } // bytes for each row

// Bytes of each row of 1000 points while Psi is solved for, in blocks of n: what is kept of Psi and a mode, right-hand
// sides with a block of probes, and what MUMPS works on.
double psi_bytes(double kept, double n) { return 8 * (kept + 1) + 8 * (n + lanczos_block) + solving(n); }

// While modes are sought.
double search_bytes(PetscInt modes) {
  const PetscInt basis = lanczos_columns(modes, static_cast<PetscInt>(rows)) + 3 * lanczos_block;
  return 8.0 * (basis + modes + 8 * lanczos_block) + solving(lanczos_block);
}

} // namespace

TEST(MemoryPlan, takes_the_fastest_way_that_has_room) {
  const ClampedStructure parts = parts_of(1000);
  const std::vector<std::tuple<bool, PetscInt, double>> ways = {{true, 256, psi_bytes(3000, 256)},
                                                                {true, 64, psi_bytes(3000, 64)},
                                                                {false, 128, psi_bytes(256, 128)},
                                                                {false, 32, search_bytes(1)}};
  for (const auto &[keep, block, bytes] : ways) {
    const double now = resident_bytes(), machine = bytes * rows * ranks(), all = sum_on_machine(PETSC_COMM_WORLD, now);
    const MemoryPlan plan = plan_memory(parts, 1, 0, 1.01 * machine);
    EXPECT_EQ(plan.keep_psi, keep);
    EXPECT_EQ(plan.block, block);
    EXPECT_NEAR((plan.bytes - now) / (bytes * rows), 1, 5e-4);
    EXPECT_NEAR((plan.machine_bytes - all) / machine, 1, 5e-4);
    EXPECT_NEAR((plan.total_bytes - all) / machine, 1, 5e-4);
    EXPECT_EQ(plan.room_bytes, 1.01 * machine);
    refuse_if_too_large(parts, plan);
    if (block != 32) {
      EXPECT_NE(plan_memory(parts, 1, 0, 0.98 * machine).block, block);
    }
  }
  const MemoryPlan least = plan_memory(parts, 1, 0, 1);
  EXPECT_EQ(least.block, 32);
  EXPECT_FALSE(least.keep_psi);
  EXPECT_THROW(refuse_if_too_large(parts, least), ComputeError);
  EXPECT_GT(plan_memory(parts, 1, 0, 0).room_bytes, resident_bytes()); // all that is free
}

TEST(MemoryPlan, counts_modes_and_rows_that_are_kept) {
  constexpr double all = 1e18;
  const double now = resident_bytes(), search = plan_memory(parts_of(1), 100, 0, all).bytes - now;
  EXPECT_NEAR(search / (search_bytes(100) * rows), 1, 2e-3);
  const ClampedStructure parts = parts_of(1000);
  const double none = plan_memory(parts, 1, 0, all).bytes, more = plan_memory(parts, 101, 0, all).bytes,
               kept = plan_memory(parts, 1, static_cast<PetscInt>(rows), all).bytes;
  EXPECT_NEAR((more - none) / (800 * rows), 1, 2e-3);
  EXPECT_NEAR((kept - none) / (8 * 3001 * rows), 1, 2e-3);
}

// One pair of nodes in each of nine sectors: five indices, each with its own complex motion.
TEST(MemoryPlan, counts_what_a_sector_keeps_of_its_motion) {
  ClampedStructure parts;
  parts.full.comm = PETSC_COMM_WORLD;
  parts.full.contact_dofs.resize(2);
  parts.full.cyclic.sectors = 9;
  parts.full.cyclic.contacts.resize(1);
  parts.full.cyclic.contacts[0].a = {0, 1, 2}, parts.full.cyclic.contacts[0].b = {3, 4, 5};
  constexpr double many = 1e6;
  const auto planned = [&](double wanted, double own) {
    parts.moved.dofs.resize(static_cast<std::size_t>(wanted)), parts.own = {0, static_cast<PetscInt>(own)};
    SecondLevel settings;
    MemoryPlan plan;
    settings.modes = 100;
    plan_sector(parts, 50, settings, plan);
    return plan.bytes;
  };
  const double least = planned(0, 0), of_each = 5 * 16 * (3 + 100) + 8 * (6 + 50);
  EXPECT_GT(planned(many, 0) - least, many * of_each);
  EXPECT_LT(planned(many, 0) - least, 1.2 * many * of_each); // with a few vectors to spare
  EXPECT_GT(planned(0, many) - least, many * 8 * (50 + 2 * 100));
}

TEST(MemoryPlan, is_said_in_words) {
  constexpr double gib = 1024.0 * 1024 * 1024;
  MemoryPlan plan;
  plan.total_bytes = 3 * gib, plan.machine_bytes = 1.5 * gib, plan.room_bytes = 2 * gib;
  const std::string words = "3 GiB over all ranks, 1.5 GiB of 2 GiB on the fullest machine";
  EXPECT_EQ(in_words(plan), words);
  plan.keep_psi = false;
  EXPECT_EQ(in_words(plan),
            words + "; too little to keep Psi, which is computed a block at a time with twice the solves");
  ClampedStructure parts = parts_of(1);
  plan.machine_bytes = plan.room_bytes;
  refuse_if_too_large(parts, plan);
  plan.machine_bytes = 4 * gib;
  try {
    refuse_if_too_large(parts, plan);
    ADD_FAILURE() << "not refused";
  } catch (const ComputeError &error) {
    const std::string said = error.what();
    EXPECT_EQ(said.find("m.h5: the reduction would take 4 GiB on a machine that has 2 GiB for it (0 GiB of it for"),
              0u);
    EXPECT_NE(said.find("K_ee). Take ranks on more machines"), std::string::npos);
  }
}

namespace {

UniqueMat any_matrix() {
  UniqueMat A;
  check(MatCreateSeqAIJ(PETSC_COMM_SELF, 1, 1, 1, nullptr, A.out()), "test");
  return A;
}

constexpr double roomy = 1e18;

} // namespace

TEST(MemoryPlan, counts_what_the_reduced_model_itself_has) {
  const auto planned = [](int points, PetscInt modes, int damped, PetscInt elastic = 10) {
    ClampedStructure parts = parts_of(points);
    parts.own = {0, 1}, parts.elastic = elastic;
    if (damped > 0) parts.C.cc = any_matrix();
    if (damped > 1) parts.K_structural.cc = any_matrix();
    const double before = resident_bytes(), bytes = plan_memory(parts, modes, 0, roomy).bytes;
    return bytes - before;
  };
  constexpr int many = 300000;
  const double nc = 3.0 * many, own = 3.0 * own_share(PETSC_COMM_WORLD, many).size();
  for (int damped = 0; damped < 3; ++damped) {
    EXPECT_NEAR(planned(many, 1, damped) / (8 * own * (2 + damped) * nc), 1, 4e-3);
    const double modes = 300000, few = 3.0 * own_share(PETSC_COMM_WORLD, 10000).size(),
                 wanted = 8 * (few * ((2 + damped) * 3e4 + (1 + damped) * modes) + damped * modes * modes);
    EXPECT_NEAR(planned(10000, 300000, damped) / wanted, 1, 0.02) << damped;
  }
  const double basis = 3e5 + 3 * 16; // of the search, three dense matrices of its order
  EXPECT_NEAR(planned(1, 100000, 0, static_cast<PetscInt>(rows)) / (3 * 8 * basis * basis), 1, 4e-3);
}

TEST(MemoryPlan, of_ranks_with_a_factor_each_advises_to_share_one) {
  const ClampedStructure parts = clamp(lattice_model(PETSC_COMM_WORLD, 12, 5, 4));
  const MemoryPlan plan = plan_memory(parts, 3, 0, 1);
  const std::string words = said<ComputeError>([&] { refuse_if_too_large(parts, plan); });
  EXPECT_EQ(
      words.find("Let the ranks share one factor (-kee_whole false; last bits then differ from run to run), take ranks "
                 "on more machines") != std::string::npos,
      ranks() > 1);
  EXPECT_EQ(words.find("for the factors of K_ee). Take ranks on more machines") != std::string::npos, ranks() == 1);
}

// One pair of nodes, and many dofs held besides: arrays of which each is as large as all dofs b, or all that moves.
TEST(MemoryPlan, counts_dense_matrices_of_a_sector) {
  const auto planned = [](int nodes, double interior, int modes, double own, double kept, int sectors) {
    ClampedStructure parts;
    parts.full.comm = PETSC_COMM_WORLD;
    parts.full.contact_dofs.resize(nodes);
    parts.full.cyclic.sectors = sectors;
    parts.full.cyclic.contacts.resize(1);
    parts.full.cyclic.contacts[0].a = {0, 1, 2}, parts.full.cyclic.contacts[0].b = {3, 4, 5};
    parts.own = {0, static_cast<PetscInt>(own)}, parts.moved.dofs.resize(static_cast<std::size_t>(kept));
    SecondLevel settings;
    settings.modes = modes;
    MemoryPlan plan;
    plan_sector(parts, static_cast<PetscInt>(interior), settings, plan);
    EXPECT_NEAR(plan.total_bytes / (ranks() * plan.bytes), 1, 0.02);
    EXPECT_NEAR(plan.machine_bytes / (ranks() * plan.bytes), 1, 0.02);
    const double now = plan.bytes - resident_bytes();
    plan.bytes = 1e30; // the first level takes more
    plan_sector(parts, static_cast<PetscInt>(interior), settings, plan);
    EXPECT_EQ(plan.bytes, 1e30);
    return now;
  };
  for (const auto &[nodes, m, modes, own, kept, sectors] : {std::tuple{2000, 10.0, 10, 10.0, 10.0, 6},
                                                            {2000, 6000.0, 10, 10.0, 10.0, 6},
                                                            {400, 10.0, 1000, 1e6, 10.0, 9},
                                                            {10, 20000.0, 10, 10.0, 10.0, 6},
                                                            {400, 500.0, 100, 10.0, 1e6, 9},
                                                            {400, 500.0, 10, 1e7, 1.0, 2}}) {
    const double b = 3 * nodes, x = 3, y = b - 3 + x - x, n = m + (y - x) + 16, a = modes + 8, indices = sectors / 2;
    const double first_level = 8 * (b * b + b * b + b * m), transformed = 16 * (3 * y * y + b * y + 2 * y * m),
                 search = 16 * (5 * n * n + 2 * n * a), index = 16 * (2 * x * x + x * a + b * a + b * x + m * a),
                 all = indices * 16 * (2 * x * x + x * a), iterated = 8 * own * (m + 10 * a),
                 motion = 16 * kept * (x + a) * (1 + indices) + 8 * kept * (b + m + 4 * x);
    const double wanted = first_level + transformed + search + index + all + iterated + motion;
    EXPECT_NEAR(planned(nodes, m, modes, own, kept, sectors) / wanted, 1, 2e-3 + 3e7 / wanted)
        << nodes << " " << m << " " << modes << " " << own << " " << kept;
  }
}
