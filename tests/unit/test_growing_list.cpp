// A copy of a growing list keeps what it had, whoever goes on.
#include <gtest/gtest.h>

#include "support/growing_list.hpp"

using dovetail::GrowingList;

namespace {

std::vector<double> all(const GrowingList &list) { return {list.begin(), list.end()}; }

} // namespace

TEST(GrowingList, a_copy_keeps_its_length) {
  GrowingList list(std::vector<double>{1, 2});
  const GrowingList copy = list;
  for (int i = 0; i < 100; ++i) list.append(std::vector<double>{3});
  EXPECT_EQ(all(copy), (std::vector<double>{1, 2}));
  EXPECT_EQ(list.size(), 102u);
}

TEST(GrowingList, both_may_grow) {
  GrowingList list;
  list.append(std::vector<double>{1});
  GrowingList copy = list;
  list.append(std::vector<double>{2});
  copy.append(std::vector<double>{3});
  list.append(std::vector<double>{4});
  EXPECT_EQ(all(list), (std::vector<double>{1, 2, 4}));
  EXPECT_EQ(all(copy), (std::vector<double>{1, 3}));
}
