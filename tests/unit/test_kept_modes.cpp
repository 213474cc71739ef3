// Modes of the stuck structure in a file of their own: when they come back, and when the file is left alone. On any
// number of ranks.
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

#include "small_model.hpp"
#include "stuck/kept_modes.hpp"
#include "support/hdf5.hpp"
#include "temporary_file.hpp"

using namespace dovetail;
using namespace dovetail::testing;

using Reals = std::vector<double>;

namespace {

// Own rows of a matrix (n, n).
Reals rows_of(const Layout &layout, int seed) {
  Reals rows;
  for (PetscInt d = 0; d < layout.own_dofs(); ++d)
    for (PetscInt j = 0; j < layout.dofs(); ++j)
      rows.push_back(wave(static_cast<int>(layout.number(d)), static_cast<int>(j) + seed));
  return rows;
}

} // namespace

TEST(KeptModes, fingerprints_are_of_all_entries_and_of_no_ranks) {
  const ReducedModel model = small_reduced(PETSC_COMM_WORLD), whole = small_reduced(PETSC_COMM_SELF);
  const Layout layout(model, 0), alone(whole, 0);
  const Reals K = rows_of(layout, 0), M = rows_of(layout, 50);
  const auto plain = fingerprint(layout, K, M);
  EXPECT_EQ(plain, fingerprint(alone, rows_of(alone, 0), rows_of(alone, 50)));
  Layout front = alone, rest = alone; // a message adds up what ranks have
  front.own_modes.end = rest.own_modes.begin = 1, front.own_points.end = rest.own_points.begin = 2;
  const auto share = [](const Layout &of) { return fingerprint(of, rows_of(of, 0), rows_of(of, 50)); };
  EXPECT_EQ(plain, share(front) + share(rest));
  EXPECT_NE(plain, fingerprint(layout, M, K));
  for (const bool of_stiffness : {true, false})
    for (const bool last : {true, false}) {
      Reals other_K = K, other_M = M, &other = of_stiffness ? other_K : other_M;
      if (!other.empty()) (last ? other.back() : other.front()) += 1e-15; // a fourth rank has no point
      EXPECT_NE(plain, fingerprint(layout, other_K, other_M));
    }
}

TEST(KeptModes, fingerprints_change_where_two_entries_change_places) {
  const ReducedModel whole = small_reduced(PETSC_COMM_SELF);
  const Layout layout(whole, 0);
  Reals K = rows_of(layout, 0);
  const Reals M = rows_of(layout, 50);
  const auto plain = fingerprint(layout, K, M);
  for (std::size_t i = 0; i < K.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      std::swap(K[i], K[j]);
      EXPECT_NE(fingerprint(layout, K, M), plain) << i << " " << j;
      std::swap(K[i], K[j]);
    }
}

// Of another size, without modes, in a file of another program.
TEST(KeptModes, are_read_where_all_of_it_fits) {
  const TemporaryFile file("kept_modes");
  const ReducedModel model = small_reduced(PETSC_COMM_WORLD), other = grounded(3, [](int) { return 1.0; });
  const Layout layout(model, 0), of_points(other, 0);
  const Reals rows = rows_of(of_points, 0), squares(9, 4.0);
  Reals lambda, modes;
  keep_modes(of_points, file.path, 5, squares, rows);
  EXPECT_FALSE(read_modes(layout, file.path, 5, lambda, modes));
  EXPECT_TRUE(read_modes(of_points, file.path, 5, lambda, modes));
  EXPECT_EQ(lambda, squares);
  EXPECT_EQ(modes, rows);
  const auto foreign = [&](const std::string &format, hsize_t counts) {
    if (rank_here() == 0) {
      h5::Writer writer(file.path);
      writer.attribute("format", format), writer.attribute("of", std::string("0000000000000005"));
      writer.rows("/squares", {counts}, 0, counts, Reals(counts).data());
      writer.rows("/modes", {9, 9}, 0, 9, Reals(81).data());
      writer.close();
    }
    MPI_Barrier(PETSC_COMM_WORLD);
  };
  foreign("dovetail-stuck", 9);
  EXPECT_TRUE(read_modes(of_points, file.path, 5, lambda, modes));
  EXPECT_EQ(lambda, Reals(9));
  foreign("dovetail-stuck", 8);
  EXPECT_FALSE(read_modes(of_points, file.path, 5, lambda, modes));
  foreign("something", 9);
  EXPECT_FALSE(read_modes(of_points, file.path, 5, lambda, modes));
  keep_modes(of_points, file.path, 5, squares, rows); // leaves it alone
  MPI_Barrier(PETSC_COMM_WORLD);
  EXPECT_EQ(h5::Reader(file.path).text_attribute("format"), "something");
}

TEST(KeptModes, come_back_for_their_fingerprint_alone) {
  const ReducedModel model = small_reduced(PETSC_COMM_WORLD);
  const Layout layout(model, 0);
  long number = getpid();
  MPI_Bcast(&number, 1, MPI_LONG, 0, layout.comm);
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / ("kept_" + std::to_string(number)),
                              file = folder / "stuck.h5", foreign = folder / "foreign.h5";
  if (layout.rank == 0) {
    std::filesystem::create_directory(folder);
    std::ofstream(foreign) << "mine";
  }
  MPI_Barrier(layout.comm);
  const Reals one = rows_of(layout, 0), two = rows_of(layout, 50), squares(11, 4.0), more(11, 9.0);
  Reals lambda = {1}, modes = {2};
  const auto expect_nothing = [&](const std::filesystem::path &path, std::uint64_t of) {
    lambda = {1}, modes = {2};
    EXPECT_FALSE(read_modes(layout, path, of, lambda, modes));
    EXPECT_EQ(lambda, Reals{1});
    EXPECT_EQ(modes, Reals{2});
  };
  expect_nothing(file, 5);
  keep_modes(layout, file, 5, squares, one);
  expect_nothing(file, 6);
  EXPECT_TRUE(read_modes(layout, file, 5, lambda, modes));
  EXPECT_EQ(lambda, squares);
  EXPECT_EQ(modes, one);
  keep_modes(layout, file, 6, more, two); // replaces it
  expect_nothing(file, 5);
  EXPECT_TRUE(read_modes(layout, file, 6, lambda, modes));
  EXPECT_EQ(lambda, more);
  EXPECT_EQ(modes, two);
  keep_modes(layout, foreign, 5, squares, one);                  // stays
  keep_modes(layout, folder / "none" / "f.h5", 5, squares, one); // nowhere
  expect_nothing(foreign, 5);
  if (layout.rank == 0) {
    std::string words;
    std::ifstream(foreign) >> words;
    EXPECT_EQ(words, "mine");
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder), {}), 2); // nothing else is left
    std::filesystem::remove_all(folder);
  }
  MPI_Barrier(layout.comm);
}
