// Cyclic sectors in reduced files: what is written is read again, and what does not fit is refused. On any number of
// ranks.
#include <gtest/gtest.h>

#include <map>

#include "reduction/reduced_model.hpp"
#include "small_model.hpp"
#include "support/error.hpp"
#include "support/hdf5.hpp"
#include "temporary_file.hpp"

namespace dovetail {
namespace {

using Complex = std::complex<double>;
using testing::said;
using testing::wave;

// Hermitian, without structure else.
Complex entry(int i, int j, int seed) {
  return {wave(i, j + seed) + wave(j, i + seed), wave(i + 7, j + seed) - wave(j + 7, i + seed)};
}

int kept_here() { return 1 + testing::rank_here(); } // rows of the motion

Reduction small_sector(int sectors) {
  Reduction made;
  const int rank = testing::rank_here();
  for (int i = 0; i < kept_here(); ++i) made.recovery.elastic_dofs.push_back(10 * rank + i);
  made.recovery.xe0.resize(kept_here());
  made.recovery.phi.resize(2 * kept_here()), made.recovery.psi.resize(9 * kept_here());
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
    LeftOutOf<Complex> &left = index.left_out;
    if (h != 2) { // of one nothing is left out
      left.squares = {7.0 + h, 8.0 + h, 9.0 + h};
      for (int j = 0; j < 2; ++j)
        left.loads.push_back({{wave(h, 5 + j), 1}, {wave(h, 7 + j), 2}, {wave(h, 9), 3.0 + j}});
      for (int i = 0; i < 6; ++i) left.with_modes.emplace_back(wave(i, h), wave(h, i));
      for (int i = 9 * model.own_points.begin; i < 9 * model.own_points.end; ++i)
        left.coupling.emplace_back(wave(i, 60 + h), wave(60 + h, i));
    }
    for (int i = 0; i < 2 * kept_here(); ++i) motion.phi.emplace_back(wave(rank, i), wave(i, h));
    for (int i = 0; i < 9 * kept_here(); ++i) motion.psi.emplace_back(wave(rank, i + h), wave(i, 3));
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
  const testing::TemporaryFile made_here{"sector"};
  const std::filesystem::path &file = made_here.path;
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
      EXPECT_EQ(found.left_out.squares, wanted.left_out.squares);
      EXPECT_EQ(found.left_out.loads, wanted.left_out.loads);
      EXPECT_EQ(found.left_out.coupling, wanted.left_out.coupling);
      EXPECT_EQ(found.left_out.with_modes, wanted.left_out.with_modes);
      const h5::Reader reader(file);
      const std::string group = "/cyclic/" + std::to_string(at + 1) + "/";
      hsize_t first = 0, total = 0;
      int ranks;
      MPI_Comm_size(PETSC_COMM_WORLD, &ranks);
      for (int rank = 0; rank < ranks; ++rank) first += rank < testing::rank_here() ? rank + 1 : 0, total += rank + 1;
      EXPECT_EQ(reader.extent(group + "Phi"), (h5::Extent{total, 2, 2}));
      EXPECT_EQ(reader.extent(group + "Psi"), (h5::Extent{total, 9, 2}));
      const auto rows = [&](const std::string &name, hsize_t columns) {
        std::vector<Complex> values;
        const auto flat = reader.doubles(group + name, {first, 0, 0}, {hsize_t(kept_here()), columns, 2});
        for (std::size_t i = 0; i < flat.size(); i += 2) values.emplace_back(flat[i], flat[i + 1]);
        return values;
      };
      EXPECT_EQ(rows("Phi", 2), made.recovery.indices[at].phi);
      EXPECT_EQ(rows("Psi", 9), made.recovery.indices[at].psi);
      EXPECT_EQ(reader.extent(group + "Max"), (h5::Extent{2, 9, 2}));
      EXPECT_EQ(reader.doubles(group + "Kaa"), wanted.kaa);
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
  EXPECT_TRUE(other([&](ReducedModel &model) { model.indices[0].left_out.squares[1] += 1e-12; }));
  EXPECT_TRUE(other([&](ReducedModel &model) { model.indices[2].left_out.with_modes[5] += i; }));
  EXPECT_TRUE(other([&](ReducedModel &model) { model.indices[2].left_out.loads[1][2] += i; }));
  EXPECT_TRUE(other([&](ReducedModel &model) { std::swap(model.indices[0], model.indices[2]); }));
  EXPECT_TRUE(other([&](ReducedModel &model) {
    if (model.own_points.size() > 0) model.indices[0].left_out.coupling[2] += i;
  }));
  EXPECT_TRUE(other([&](ReducedModel &model) {
    if (model.own_points.size() > 0) model.indices[1].loads[1].fx[2] += i;
  }));
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

// A file of one contact point and one mode of four sectors, with that dataset of another shape or another first number.
struct Other {
  std::string name;
  h5::Extent shape = {};
  double first = 1;
};

void write_by_hand(const std::filesystem::path &file, const Other &other) {
  MPI_Barrier(PETSC_COMM_WORLD);
  if (testing::rank_here() == 0) {
    h5::Writer writer(file);
    writer.attribute("format", "dovetail-reduced");
    std::map<std::string, h5::Extent> sets = {{"/Kaa", {1}}, {"/Max", {1, 3}}, {"/Kxx", {3, 3}}, {"/Mxx", {3, 3}},
                                              {"/Fa", {1}},  {"/Fx", {3}},     {"/R", {3}}};
    for (const std::string group : {"/cyclic/1/", "/cyclic/2/"})
      for (const auto &[name, shape] : std::map<std::string, h5::Extent>{{"Kaa", {1}},
                                                                         {"Max", {1, 3, 2}},
                                                                         {"Kxx", {3, 3, 2}},
                                                                         {"Mxx", {3, 3, 2}},
                                                                         {"Fa", {1, 1, 2}},
                                                                         {"Fx", {1, 3, 2}},
                                                                         {"left_out/Kaa", {2}},
                                                                         {"left_out/Fa", {1, 2, 2}},
                                                                         {"left_out/Max", {2, 3, 2}},
                                                                         {"left_out/Maa", {1, 2, 2}}})
        sets[group + name] = shape;
    if (!other.shape.empty()) sets.at(other.name) = other.shape;
    for (const auto &[name, shape] : sets) {
      hsize_t count = 1;
      for (const hsize_t n : shape) count *= n;
      std::vector<double> values(count, 1.0); // Hermitian but for imaginary parts
      for (hsize_t i = 1; i < count && shape.back() == 2 && shape.size() == 3; i += 2) values[i] = 0;
      if (name == other.name) values.at(0) = other.first;
      writer.rows(name, shape, 0, shape[0], values.data());
    }
    writer.attribute("sectors", 4L, "/cyclic");
    writer.close();
  }
  MPI_Barrier(PETSC_COMM_WORLD);
}

TEST_F(SectorFile, ShapesAndNumbersThatDoNotFitAreRefused) {
  const auto words = [&](const Other &other) {
    write_by_hand(file, other);
    return said<InputError>([&] { read_reduced(PETSC_COMM_WORLD, file); });
  };
  EXPECT_EQ(words({""}), "nothing was thrown");
  const std::vector<std::tuple<std::string, h5::Extent, std::string>> shapes = {
      {"Kaa", {2}, "(2) where (1) is"},
      {"Max", {3, 1, 2}, "(3, 1, 2) where (1, 3, 2) is"},
      {"Kxx", {3, 3}, "(3, 3) where (3, 3, 2) is"},
      {"Mxx", {3, 2, 2}, "(3, 2, 2) where (3, 3, 2) is"},
      {"Fa", {1, 1}, "(1, 1) where (1, 1, 2) is"},
      {"Fx", {2, 3, 2}, "(2, 3, 2) where (1, 3, 2) is"},
      {"left_out/Fa", {1, 3, 2}, "(1, 3, 2) where (1, 2, 2) is"},
      {"left_out/Max", {2, 2, 2}, "(2, 2, 2) where (2, 3, 2) is"},
      {"left_out/Maa", {2, 2, 2}, "(2, 2, 2) where (1, 2, 2) is"}};
  for (const auto &[name, shape, said_of_it] : shapes)
    for (const std::string group : {"/cyclic/1/", "/cyclic/2/"})
      EXPECT_EQ(words({group + name, shape}),
                file.string() + ": " + group + name + ": shape " + said_of_it + " wanted");
  for (const std::string name : {"/cyclic/1/Kaa", "/cyclic/2/left_out/Kaa"})
    for (const auto &[value, shown] : {std::pair{0.0, "0.000000"}, {INFINITY, "inf"}, {-1.0, "-1.000000"}})
      EXPECT_EQ(words({name, {}, value}),
                file.string() + ": " + name + ": " + shown + "; squared frequencies above 0 are wanted");
  for (const std::string name : {"Max", "Kxx", "Mxx", "Fa", "Fx", "left_out/Fa", "left_out/Max", "left_out/Maa"})
    EXPECT_EQ(words({"/cyclic/2/" + name, {}, INFINITY}),
              file.string() + ": /cyclic/2/" + name + ": inf, 0.000000; finite numbers are wanted");
}

TEST_F(SectorFile, HermitianButForRoundingErrors) {
  const auto off = [&](Complex by, int place = 1) {
    Reduction made = small_sector(6);
    double most = 0;
    SectorIndex &index = made.model.indices[1];
    for (const Complex value : index.kxx) most = std::max(most, std::abs(value)); // first rank: of its own rows
    MPI_Bcast(&most, 1, MPI_DOUBLE, 0, PETSC_COMM_WORLD);
    if (testing::rank_here() == 0) index.kxx[place] += by * most;
    write_reduced(file, of_three_points(), made);
    const std::string words = said<InputError>([&] { read_reduced(PETSC_COMM_WORLD, file); });
    MPI_Barrier(PETSC_COMM_WORLD); // before it is written again
    return words;
  };
  for (const Complex by : {Complex(0.7e-8), Complex(-0.7e-8), Complex(0, 0.7e-8), Complex(0, -0.7e-8)})
    EXPECT_EQ(off(by), "nothing was thrown");
  for (const Complex by : {Complex(1.5e-8), Complex(-1.5e-8), Complex(0, 1.5e-8), Complex(0, -1.5e-8)})
    EXPECT_EQ(off(by), file.string() + ": /cyclic/2/Kxx: not Hermitian, row 0, column 1 (of 0..)");
  EXPECT_EQ(off(Complex(0, 1), 10), file.string() + ": /cyclic/2/Kxx: not Hermitian, row 1, column 1 (of 0..)");
}

TEST_F(SectorFile, AMissingIndexIsNamed) {
  Reduction made = small_sector(7);
  made.model.indices.pop_back(), made.recovery.indices.pop_back();
  write_reduced(file, of_three_points(), made);
  EXPECT_EQ(said<InputError>([&] { read_reduced(PETSC_COMM_WORLD, file); }),
            file.string() + ": /cyclic: index 3 is missing; of 7 sectors a group for each of 1 to 3 is wanted");
}

} // namespace
} // namespace dovetail
