// GoogleTest under MPI: every rank runs every test, the verdict is that of the worst rank, rank 0 reports.
#include <gtest/gtest.h>
#include <slepc.h>

#include "support/error.hpp"
#include "support/mumps.hpp"

int main(int argc, char **argv) {
  ::testing::InitGoogleTest(&argc, argv);
  dovetail::order_the_same_way();
  SlepcInitialize(&argc, &argv, nullptr, nullptr);
  dovetail::install_error_handler();
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  auto &listeners = ::testing::UnitTest::GetInstance()->listeners();
  if (rank > 0) delete listeners.Release(listeners.default_result_printer());
  int failed = RUN_ALL_TESTS();
  MPI_Allreduce(MPI_IN_PLACE, &failed, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
  SlepcFinalize();
  return failed;
}
