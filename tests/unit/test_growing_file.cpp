// Tables that grow row by row in a file that opens at any moment (tests/python/test_survival.py looks at every moment).
#include <gtest/gtest.h>
#include <unistd.h>

#include <numeric>

#include "support/error.hpp"
#include "support/hdf5.hpp"

namespace dovetail {
namespace {

namespace fs = std::filesystem;
using h5::Extent;

class GrowingFile : public ::testing::Test {
protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "dovetail-growing-XXXXXX").string(); // every rank has its own
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    folder = name;
    path = folder / "results.h5";
  }
  void TearDown() override { fs::remove_all(folder); }
  std::vector<double> row(int number, int size) const {
    std::vector<double> values(size);
    std::iota(values.begin(), values.end(), 1000.0 * number + 1);
    return values;
  }
  fs::path folder, path;
};

// With one row to a chunk, more rows than one node of the index of chunks holds (64), and than its first split leaves
// room for.
TEST_F(GrowingFile, IndexGrowsOverItsNodes) {
  constexpr int rows = 150;
  h5::Writer file = h5::Writer::that_survives(folder / "results.h5.partial");
  h5::Table block(file, "/points/coefficients", {2, 3}, H5T_NATIVE_DOUBLE, 1);
  h5::Table number(file, "/points/omega", {}, H5T_NATIVE_DOUBLE, 4);
  file.flush();
  fs::rename(folder / "results.h5.partial", path);
  for (int i = 0; i < rows; ++i) {
    block.append(row(i, 6).data());
    number.append(row(i, 1).data());
    file.flush();
    const h5::Reader now(path); // while it is written
    EXPECT_EQ(now.extent("/points/omega"), Extent{hsize_t(i) + 1});
    EXPECT_EQ(now.doubles("/points/coefficients", {hsize_t(i), 0, 0}, {1, 2, 3}), row(i, 6));
    EXPECT_EQ(now.doubles("/points/coefficients", {0, 0, 0}, {1, 2, 3}), row(0, 6));
  }
  const auto all = h5::Reader(path).doubles("/points/coefficients");
  for (int i = 0; i < rows; ++i) EXPECT_EQ(std::vector<double>(&all[6 * i], &all[6 * i] + 6), row(i, 6));
}

TEST_F(GrowingFile, RowsGetLonger) {
  h5::Writer file = h5::Writer::that_survives(path);
  h5::Table table(file, "/points/coefficients", {2, 3}, H5T_NATIVE_DOUBLE, 4, true);
  table.append(row(1, 6).data());
  table.append(row(2, 6).data());
  table.widen(7);
  EXPECT_EQ(table.width(), 7u);
  table.append(row(3, 14).data());
  table.append(row(4, 6).data(), 1, 3); // a shorter one again
  std::vector<double> two = row(5, 6);
  for (const double value : row(6, 6)) two.push_back(value);
  table.append(two.data(), 2, 3); // beyond a chunk's end
  file.flush();
  const h5::Reader now(path);
  EXPECT_EQ(now.extent("/points/coefficients"), (Extent{6, 2, 7}));
  const auto all = now.doubles("/points/coefficients");
  const auto expected = [&](int number, int width) {
    const auto short_row = row(number, 2 * width);
    std::vector<double> padded(14, 0.0);
    for (int d = 0; d < 2; ++d)
      for (int i = 0; i < width; ++i) padded[7 * d + i] = short_row[width * d + i];
    return padded;
  };
  for (int i = 0; i < 6; ++i)
    EXPECT_EQ(std::vector<double>(&all[14 * i], &all[14 * i] + 14), expected(i + 1, i == 2 ? 7 : 3)) << i;
}

TEST_F(GrowingFile, ManyRowsAtOnce) {
  h5::Writer file = h5::Writer::that_survives(path);
  h5::Table table(file, "/a", {2}, H5T_NATIVE_DOUBLE, 3);
  table.append(row(0, 14).data(), 7);
  table.append(row(1, 2).data());
  table.append(nullptr, 0);
  file.flush();
  auto expected = row(0, 14);
  for (const double value : row(1, 2)) expected.push_back(value);
  EXPECT_EQ(h5::Reader(path).doubles("/a"), expected);
}

TEST_F(GrowingFile, NothingIsWrittenBeforeItIsFlushed) {
  h5::Writer file = h5::Writer::that_survives(path);
  h5::Table table(file, "/a", {}, H5T_NATIVE_DOUBLE, 4);
  table.append(row(0, 1).data());
  file.flush();
  table.append(row(1, 1).data());
  EXPECT_EQ(h5::Reader(path).extent("/a"), Extent{1});
  file.flush();
  EXPECT_EQ(h5::Reader(path).extent("/a"), Extent{2});
}

TEST_F(GrowingFile, AttributesCanChange) {
  {
    h5::Writer file = h5::Writer::that_survives(path);
    h5::Table table(file, "/a", {}, H5T_NATIVE_DOUBLE, 4);
    file.attribute("harmonics", 3);
    for (int i = 0; i < 12; ++i) file.attribute("other" + std::to_string(i), std::string(700 * i, 'x'));
    file.attribute("names", "one two", "/a");
    file.flush();
    file.attribute("harmonics", 9);
  }
  const h5::Reader file(path);
  EXPECT_EQ(file.integer_attribute("harmonics", 0), 9);
  EXPECT_EQ(file.text_attribute("other11"), std::string(7700, 'x'));
}

} // namespace
} // namespace dovetail
