// Labels of units: tests/units.txt, as in tests/python/test_units.py.
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>
#include <vector>

#include "support/units.hpp"

namespace dovetail {
namespace {

std::string trimmed(const std::string &text) {
  const auto first = text.find_first_not_of(' '), last = text.find_last_not_of(' ');
  return first == std::string::npos ? "" : text.substr(first, last - first + 1);
}

TEST(Units, LabelsAreUnderstoodOrGivePlainNumbers) {
  std::ifstream table(DOVETAIL_TESTS "/units.txt");
  int cases = 0;
  for (std::string line; std::getline(table, line);) {
    if (line[0] == '#') continue;
    std::vector<std::string> words;
    std::istringstream row(line);
    for (std::string word; std::getline(row, word, '|');) words.push_back(trimmed(word));
    ASSERT_EQ(words.size(), 10U) << line;
    const Units units = units_of(words[0]);
    const std::string found[] = {units.length, units.mass,   units.time,  units.force,
                                 units.energy, units.stress, units.modal, units.omega};
    for (int i = 0; i < 8; ++i) EXPECT_EQ(found[i], words[i + 1]) << line;
    EXPECT_NEAR(units.hertz(1) / std::stod(words[9]), 1, 1e-15) << line;
    ++cases;
  }
  EXPECT_GT(cases, 20);
}

TEST(Units, StandInPlaceOfThoseOfTheSI) {
  const Units known = units_of("kg, mm, ms"), unknown = units_of("none");
  EXPECT_EQ(known.instead_of("N/m"), "kN/mm");
  EXPECT_EQ(known.instead_of("m"), "mm");
  EXPECT_EQ(known.instead_of("1/s"), "1/ms");
  EXPECT_EQ(known.instead_of("rad/s"), "rad/ms");
  EXPECT_EQ(known.instead_of("-"), "-");
  EXPECT_EQ(unknown.instead_of("N/m"), "");
  EXPECT_EQ(unknown.instead_of("rad/s"), "rad/s");
  EXPECT_EQ("1" + behind_number(known.length), "1 mm");
  EXPECT_EQ("1" + behind_number(unknown.length), "1");
}

} // namespace
} // namespace dovetail
