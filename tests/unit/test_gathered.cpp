// Numbers of all ranks in one place, and what is too much for the counts of MPI and LAPACK.
#include <gtest/gtest.h>
#include <petscsys.h>

#include "support/block_cyclic.hpp"
#include "support/gathered.hpp"

using namespace dovetail;

namespace {

void expect_refused(const std::function<void()> &work, const std::string &words) {
  try {
    work();
    ADD_FAILURE() << "not refused: " << words;
  } catch (const ComputeError &error) {
    EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
  }
}

} // namespace

TEST(Gathered, one_rank_after_the_other) {
  int rank, size;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  MPI_Comm_size(PETSC_COMM_WORLD, &size);
  const std::vector<int> all = gathered(PETSC_COMM_WORLD, MPI_INT, std::vector<int>(rank, rank)); // rank 0 has none
  std::vector<int> wanted;
  for (int r = 0; r < size; ++r) wanted.insert(wanted.end(), r, r);
  EXPECT_EQ(all, wanted);
  EXPECT_EQ(gathered(PETSC_COMM_WORLD, MPI_INT, std::vector<int>(1, rank), 0).size(),
            std::size_t(rank == 0 ? size : 0));
}

TEST(Gathered, more_than_an_int_counts_is_refused) {
  EXPECT_EQ(places_of({2000000000, 147483647}), (std::vector<int>{0, 2000000000, 2147483647}));
  expect_refused([] { places_of({2000000000, 147483648}); }, "2147483648 is beyond the 32-bit counts");
  expect_refused([] { places_of({5000000000}); }, "5000000000 is beyond");
}

TEST(Gathered, a_matrix_beyond_the_counts_of_ScaLAPACK_is_refused) {
  int size;
  MPI_Comm_size(PETSC_COMM_WORLD, &size);
  expect_refused([&] { BlockCyclic(PETSC_COMM_WORLD, 200000, std::vector<std::vector<int>>(size)); },
                 "take more ranks");
}
