// Saving and restoring by one list of named fields.
#include <gtest/gtest.h>

#include <limits>

#include "support/archive.hpp"

using namespace dovetail;

namespace {

struct Walker {
  double step = 0;
  int turns = 0;
  bool lost = false;
  std::vector<double> way;

  void archive(Archive &archive) {
    archive.field("step", step);
    archive.field("turns", turns);
    archive.part("path", [&] {
      archive.field("lost", lost);
      archive.field("step", way); // another field than the one above
    });
  }
};

} // namespace

TEST(Archive, restores_what_was_saved_whatever_the_order) {
  Walker one{-0.0, 7, true, {1, std::numeric_limits<double>::infinity()}}, other;
  Archive saved;
  one.archive(saved);
  Archive::Fields fields = saved.fields();
  ASSERT_EQ(fields.names.size(), 4u);
  EXPECT_EQ(fields.names[3].first, "path.step");
  Archive again(fields);
  std::vector<double> way;
  again.part("path", [&] { again.field("step", way); });
  EXPECT_EQ(way, one.way);
  other.archive(again);
  EXPECT_TRUE(std::signbit(other.step));
  EXPECT_EQ(other.turns, 7);
  EXPECT_TRUE(other.lost);
  EXPECT_EQ(other.way, one.way);
}

TEST(Archive, says_what_is_missing_or_no_number) {
  Walker one, other;
  Archive saved;
  one.archive(saved);
  const auto told = [&](auto &&spoil) {
    Archive::Fields fields = saved.fields();
    spoil(fields);
    Archive again(fields);
    try {
      other.archive(again);
    } catch (const ComputeError &error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_EQ(told([](Archive::Fields &fields) { fields.names[2].first = "path.found"; }),
            "path.lost is missing in the saved state");
  EXPECT_EQ(told([](Archive::Fields &fields) { fields.names[1].second = 2; }),
            "turns is not one number in the saved state");
  EXPECT_EQ(told([](Archive::Fields &) {}), "");
}
