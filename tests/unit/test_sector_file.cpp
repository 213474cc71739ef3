// Cyclic sectors in reduced files: what is written is read again, and what does not fit is refused. On any number of
// ranks.
#include <gtest/gtest.h>

#include <unistd.h>

#include "reduction/reduced_model.hpp"
#include "small_model.hpp"
#include "support/error.hpp"
#include "support/hdf5.hpp"

namespace dovetail {
namespace {

using Complex = std::complex<double>;
using testing::wave;

// Hermitian, without structure else.
Complex entry(int i, int j, int seed) {
  return {wave(i, j + seed) + wave(j, i + seed), wave(i + 7, j + seed) - wave(j + 7, i + seed)};
}

Reduction small_sector(int sectors) {
  Reduction made;
  ReducedModel &model = made.model = testing::small_reduced(PETSC_COMM_WORLD);
  model.loads.push_back({"second", {0.1, 0.2}, model.loads[0].fx});
  model.sectors = sectors;
  for (int h = 1; h <= sectors / 2; ++h) {
    SectorIndex index;
    index.kaa = {1.0 + h, 5.0 + h};
    index.loads.resize(2);
    for (SectorIndex::Load &load : index.loads) load.fa = {{wave(h, 1), wave(h, 2)}, {wave(h, 3), wave(h, 4)}};
    Recovery::OfIndex motion;
    for (int i = 3 * model.own_points.begin; i < 3 * model.own_points.end; ++i) {
      for (int j = 0; j < 2; ++j) index.mxa.emplace_back(wave(i, j + h), wave(j, i + h));
      for (int j = 0; j < 9; ++j) index.kxx.push_back(entry(i, j, h)), index.mxx.push_back(entry(i, j, 30 + h));
      for (int j = 0; j < 2; ++j) index.loads[j].fx.emplace_back(wave(i, h + j), wave(i, h - j));
    }
    model.indices.push_back(index), made.recovery.indices.push_back(motion);
  }
  model.fingerprint = fingerprint_of(model);
  return made;
}

Source of_three_points() {
  Source source;
  source.contact_dofs = {{-1, -1, -1}, {-1, -1, -1}, {-1, -1, -1}};
  return source;
}

class SectorFile : public ::testing::Test {
protected:
  std::filesystem::path file; // the same on all ranks

  SectorFile() {
    long name = getpid();
    MPI_Bcast(&name, 1, MPI_LONG, 0, PETSC_COMM_WORLD);
    file = std::filesystem::temp_directory_path() / ("sector_" + std::to_string(name) + ".h5");
  }
  ~SectorFile() override {
    MPI_Barrier(PETSC_COMM_WORLD);
    std::filesystem::remove(file);
  }
};

TEST_F(SectorFile, IsReadAsItWasWritten) {
  for (const int sectors : {2, 5, 6}) {
    const Reduction made = small_sector(sectors);
    write_reduced(file, of_three_points(), made);
    EXPECT_EQ(read_reduced_header(file).sectors, sectors);
    const ReducedModel read = read_reduced(PETSC_COMM_WORLD, file);
    EXPECT_TRUE(read.as_written);
    EXPECT_EQ(read.sectors, sectors);
    ASSERT_EQ(read.indices.size(), made.model.indices.size());
    for (std::size_t at = 0; at < read.indices.size(); ++at) {
      const SectorIndex &found = read.indices[at], &wanted = made.model.indices[at];
      EXPECT_EQ(found.kaa, wanted.kaa);
      EXPECT_EQ(found.mxa, wanted.mxa);
      EXPECT_EQ(found.mxx, wanted.mxx);
      EXPECT_EQ(found.kxx, wanted.kxx);
      for (int j = 0; j < 2; ++j) {
        EXPECT_EQ(found.loads[j].fa, wanted.loads[j].fa);
        EXPECT_EQ(found.loads[j].fx, wanted.loads[j].fx);
      }
    }
    MPI_Barrier(PETSC_COMM_WORLD); // before it is written again
  }
}

TEST_F(SectorFile, AModelWithoutSectorsSaysSo) {
  Reduction made = small_sector(6);
  const std::string cyclic = made.model.fingerprint;
  made.model.sectors = 0, made.model.indices.clear(), made.recovery.indices.clear();
  made.model.fingerprint = fingerprint_of(made.model);
  EXPECT_NE(made.model.fingerprint, cyclic);
  write_reduced(file, of_three_points(), made);
  const ReducedModel read = read_reduced(PETSC_COMM_WORLD, file);
  EXPECT_TRUE(read.as_written);
  EXPECT_EQ(read.sectors, 0);
  EXPECT_TRUE(read.indices.empty());
}

TEST_F(SectorFile, EveryNumberIsInTheFingerprint) {
  const Reduction made = small_sector(6);
  const auto other = [&](auto &&change) {
    ReducedModel model = made.model;
    change(model);
    return fingerprint_of(model) != made.model.fingerprint;
  };
  const Complex i(0, 1e-12);
  EXPECT_TRUE(other([&](ReducedModel &model) { model.indices[2].kaa[0] += 1e-12; }));
  EXPECT_TRUE(other([&](ReducedModel &model) { model.indices[1].loads[1].fa[0] += i; }));
  EXPECT_TRUE(other([&](ReducedModel &model) { model.sectors = 7; }));
  for (auto values : {&SectorIndex::mxa, &SectorIndex::mxx, &SectorIndex::kxx})
    EXPECT_TRUE(other([&](ReducedModel &model) {
      if (model.own_points.size() > 0) (model.indices[0].*values)[0] += i;
    }));
}

TEST_F(SectorFile, AMissingIndexAndAMatrixThatIsNotHermitianAreRefused) {
  Reduction made = small_sector(6);
  const int first = made.model.own_points.begin;
  made.model.indices.pop_back(), made.recovery.indices.pop_back();
  write_reduced(file, of_three_points(), made);
  EXPECT_THROW(read_reduced(PETSC_COMM_WORLD, file), InputError);
  MPI_Barrier(PETSC_COMM_WORLD);
  made = small_sector(6);
  if (first == 0 && made.model.own_points.size() > 0) made.model.indices[1].kxx[1] += Complex(0, 0.1);
  write_reduced(file, of_three_points(), made);
  EXPECT_THROW(read_reduced(PETSC_COMM_WORLD, file), InputError);
}

TEST_F(SectorFile, ANumberThatIsNotFiniteIsToldAsItStands) {
  for (const auto &[value, words] :
       {std::pair{Complex(0.25, INFINITY), "0.250000, inf"}, {Complex(-INFINITY, 0.5), "-inf, 0.500000"}}) {
    Reduction made = small_sector(6);
    made.model.indices[0].loads[0].fa[1] = value;
    write_reduced(file, of_three_points(), made);
    try {
      read_reduced(PETSC_COMM_WORLD, file);
      ADD_FAILURE() << "not refused";
    } catch (const InputError &error) {
      EXPECT_NE(std::string(error.what()).find(": " + std::string(words) + "; finite numbers are wanted"),
                std::string::npos)
          << error.what();
    }
    MPI_Barrier(PETSC_COMM_WORLD); // before it is written again
  }
}

} // namespace
} // namespace dovetail
