// The table of keys says what the parser does: of every key, what it allows is taken, what it does not is refused in
// its name, and the default that it names is in force.
#include "case/case.hpp"
#include "case/contact_settings.hpp"
#include "case/keys.hpp"
#include "case/number_text.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <fstream>
#include <map>
#include <set>

#include "support/error.hpp"

namespace dovetail {
namespace {

namespace fs = std::filesystem;
using Kind = Value::Kind;
using Shape = Value::Shape;
using Settings = std::map<std::string, std::string>; ///< key -> value as written
using Texts = std::vector<std::string>;

const Settings smallest = {{"model", "\"model.h5\""},
                           {"reduction.modes", "2"},
                           {"excitation.fourier", "[0, 1]"},
                           {"harmonic_balance.harmonics", "1"},
                           {"continuation.omega", "[0.9, 1.3]"}};

/// What stands beside a key for it to be taken: of its section, of the key, or of one value. Empty: the line goes.
const std::map<std::string, Settings> beside = {
    {"reduced", {{"model", ""}, {"reduction.modes", ""}}},
    {"damping.of", {{"damping.ratios", "[[1, 0.1]]"}}},
    {"damping.contact", {{"damping.stiffness", "1"}}},
    {"excitation.load", {{"excitation.fourier", ""}}},
    {"accuracy.tolerance", {{"harmonic_balance.harmonics", ""}}},
    {"scaling.kind = \"manual\"", {{"scaling.frequency", "1"}, {"scaling.modal", "1"}, {"scaling.contact", "1"}}},
    {"scaling.frequency", {{"scaling.kind", "\"manual\""}, {"scaling.modal", "1"}, {"scaling.contact", "1"}}},
    {"scaling.modal", {{"scaling.kind", "\"manual\""}, {"scaling.frequency", "1"}, {"scaling.contact", "1"}}},
    {"scaling.contact", {{"scaling.kind", "\"manual\""}, {"scaling.modal", "1"}, {"scaling.frequency", "1"}}},
    {"path",
     {{"continuation.omega", ""}, {"path.parameter", "\"gap\""}, {"path.range", "[0.5, 2]"}, {"path.omega", "1"}}},
    {"path.peak", {{"path.omega", ""}, {"continuation.omega", "[0.9, 1.3]"}, {"continuation.watch", "\"x1.t1\""}}},
    {"mode", {{"continuation.omega", ""}, {"mode.number", "1"}, {"mode.amplitude", "[0.5, 2]"}}},
    {"mode.near", {{"mode.number", ""}}},
};

const std::map<std::string, std::string> good_texts = {{"model", "model.h5"},
                                                       {"reduced", "reduced.h5"},
                                                       {"continuation.start", "start.h5"},
                                                       {"continuation.watch", "x1.t1"},
                                                       {"sensitivity.of", "x1.t1"}};

std::string quoted(const std::string &word) { return '"' + word + '"'; }

Texts good_ones(const std::string &name, const Value &value) {
  Texts out;
  const bool whole = value.kind == Kind::whole;
  switch (value.kind) {
  case Kind::text: {
    const auto found = good_texts.find(name);
    return {quoted(found == good_texts.end() ? "some" : found->second)};
  }
  case Kind::truth:
    return {"true", "false"};
  case Kind::word:
    break;
  case Kind::node:
    return {"\"tip\"", "0", "12"};
  case Kind::number:
  case Kind::whole:
    if (value.fault(1).empty()) out.push_back("1");
    if (std::isfinite(value.low))
      out.push_back(whole ? std::to_string(long(value.low))
                          : number_text(value.open_low ? value.low + 1e-3 : value.low));
    if (std::isfinite(value.high))
      out.push_back(whole ? std::to_string(long(value.high))
                          : number_text(value.open_high ? value.high - 1e-3 : value.high));
    break;
  case Kind::tables:
    return {};
  }
  for (const std::string &word : value.words) out.push_back(quoted(word));
  return out;
}

Texts bad_ones(const Value &value) {
  switch (value.kind) {
  case Kind::text:
    return {"1", "true", "\"\"", "[1]", "2026-01-01"};
  case Kind::truth:
    return {"1", "\"true\"", "[true]", "0"};
  case Kind::word:
    return {"\"other\"", "1", "true", quoted(value.words[0] + " "), "\"\""};
  case Kind::node:
    return {"-1", "1.5", "true"};
  case Kind::number:
  case Kind::whole:
    break;
  case Kind::tables:
    return {"1", "[1]", "\"some\""};
  }
  Texts out = {"\"other\"", "true", "nan", "inf"};
  const bool whole = value.kind == Kind::whole;
  if (whole) out.push_back("1.5"), out.push_back("1.0");
  const auto beyond = [&](double bound, bool open, int away) {
    if (std::isfinite(bound))
      out.push_back(whole ? std::to_string(long(bound) + away) : number_text(open ? bound : bound + away * 1e-3));
  };
  beyond(value.low, value.open_low, -1), beyond(value.high, value.open_high, 1);
  return out;
}

Texts good_values(const Key &key) {
  Value value = key.value;
  const bool or_word = value.kind != Kind::word && !value.words.empty();
  Texts out, words;
  if (or_word && value.shape != Shape::one) words = value.words, value.words.clear(); // alone, and not in the list
  const Texts ones = good_ones(key.name, value);
  for (const std::string &word : words) out.push_back(quoted(word));
  const auto lists = [&] {
    if (value.kind == Kind::number) return out.push_back("[1, 1.25, 1.3]");
    if (value.kind == Kind::whole) return out.push_back("[1, 2, 3]");
    for (const std::string &one : ones) out.push_back("[" + one + "]");
  };
  switch (value.shape) {
  case Shape::one:
    return ones;
  case Shape::list:
    lists();
    break;
  case Shape::pair:
    out = {"[1, 1.25]"};
    if (std::isfinite(value.low)) out.push_back("[" + ones[1] + ", 1.25]");
    break;
  case Shape::one_or_pairs:
    out = {"[1, 2]", "[[1, 2]]", "[[1, 2], [3, 4], [5, 6]]"};
    [[fallthrough]];
  case Shape::one_or_list:
    out.insert(out.end(), ones.begin(), ones.end());
    lists();
    break;
  case Shape::ratios:
    out = {"[[1, 0]]", "[[3, 0.1], [1, 1]]"};
    break;
  }
  return out;
}

Texts bad_values(const Key &key) {
  const Value &value = key.value;
  Texts out;
  const auto around = [&](const std::string &before, const std::string &behind) {
    for (const std::string &bad : bad_ones(value)) out.push_back(before + bad + behind);
  };
  const std::string one = value.kind == Kind::word ? quoted(value.words[0]) : "1";
  switch (value.shape) {
  case Shape::one:
    around("", "");
    out.push_back("[" + one + "]"), out.push_back("{}");
    break;
  case Shape::list:
    around("[", "]");
    out.push_back(one);
    break;
  case Shape::pair:
    around("[", ", 1.25]");
    out.insert(out.end(), {"1", "[1]", "[1, 1.1, 1.2]", "[[1, 1.25]]"});
    break;
  case Shape::one_or_pairs:
    around("[[1, ", "]]");
    out.push_back("[[1, 2, 3]]");
    [[fallthrough]];
  case Shape::one_or_list:
    around("", ""), around("[" + one + ", ", "]");
    out.push_back("[]");
    break;
  case Shape::ratios:
    around("[[1, ", "]]");
    out.insert(out.end(), {"[]", "[1, 0.1]", "[[0, 0.1]]", "[[1.5, 0.1]]", "[[1]]", "0.1"});
    break;
  }
  return out;
}

class Keys : public ::testing::Test {
protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "dovetail-keys-XXXXXX").string();
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    folder = name;
    for (const char *file : {"model.h5", "reduced.h5", "start.h5"}) std::ofstream(folder / file) << "x";
  }
  void TearDown() override { fs::remove_all(folder); }

  /// A case with what the key wants beside it, and the key itself, if it is given a value.
  Case read(const std::string &key, const std::string &value = "") const {
    Settings settings = smallest;
    for (const std::string &name : {key.substr(0, key.find('.')), key, key + " = " + value})
      if (const auto found = beside.find(name); found != beside.end())
        for (const auto &[other, text] : found->second) settings[other] = text;
    settings[key] = value;
    std::map<std::string, std::string> sections;
    for (const auto &[name, text] : settings)
      if (const auto dot = name.find('.'); !text.empty())
        sections[dot == std::string::npos ? "" : name.substr(0, dot)] += name.substr(dot + 1) + " = " + text + "\n";
    std::string text = sections[""];
    for (const auto &[section, lines] : sections)
      if (!section.empty()) text += "[" + section + "]\n" + lines;
    std::ofstream(folder / "case.toml") << text;
    return read_case(folder / "case.toml", {});
  }
  std::string complaint(const std::string &key, const std::string &value) const {
    try {
      read(key, value);
    } catch (const InputError &error) {
      return error.what();
    }
    return "";
  }
  fs::path folder;
};

bool in_a_list(const Key &key) { return std::string(key.name).rfind("excitation.load.", 0) == 0; }

TEST_F(Keys, stand_once_and_say_what_they_are) {
  std::set<std::string> names;
  for (const Key &key : keys()) {
    EXPECT_TRUE(names.insert(key.name).second) << key.name;
    const std::string help = key.help;
    EXPECT_TRUE(help.size() > 2 && help.size() < 120 && help.back() != '.') << key.name << ": " << help;
    EXPECT_NE(std::string(key.standard), "") << key.name;
    EXPECT_EQ(key_named(key.name), &key);
  }
  EXPECT_EQ(key_named("none.such"), nullptr);
}

TEST_F(Keys, what_the_table_allows_is_taken) {
  for (const Key &key : keys())
    for (const std::string &value : good_values(key)) {
      if (in_a_list(key)) continue;
      EXPECT_EQ(complaint(key.name, value), "") << key.name << " = " << value;
    }
}

TEST_F(Keys, what_it_does_not_allow_is_refused_in_the_name_of_the_key) {
  for (const Key &key : keys())
    for (const std::string &value : bad_values(key)) {
      if (in_a_list(key)) continue;
      const std::string why = complaint(key.name, value);
      EXPECT_NE(why.find(key.name), std::string::npos) << key.name << " = " << value << " gives: " << why;
    }
}

TEST_F(Keys, bounds_and_words_are_those_of_the_table) {
  for (const Key &key : keys()) {
    if (key.value.kind != Kind::number && key.value.kind != Kind::whole && key.value.kind != Kind::word) continue;
    if (in_a_list(key) || key.value.shape == Shape::ratios) continue;
    const bool list = key.value.shape == Shape::list || key.value.shape == Shape::pair;
    const auto complains = [&](const std::string &value, const std::string &words) {
      const std::string why = complaint(key.name, list ? "[" + value + ", 1.25]" : value);
      EXPECT_NE(why.find(words), std::string::npos) << key.name << " = " << value << " gives: " << why;
    };
    if (key.value.kind == Kind::word) complains("\"other\"", key.value.words_text());
    for (const double value : {key.value.low - 1, key.value.high + 1})
      if (std::isfinite(value))
        complains(key.value.kind == Kind::whole ? std::to_string(long(value)) : number_text(value),
                  key.value.fault(value));
  }
}

TEST_F(Keys, the_default_of_the_table_is_in_force) {
  int checked = 0;
  for (const Key &key : keys()) {
    if (!key.has_standard_value()) continue;
    const Case study = read(key.name);
    std::string wanted = key.standard, found = key.text ? key.text(study) : "";
    if (wanted.front() == '"') wanted = wanted.substr(1, wanted.size() - 2);
    if (key.name == std::string("contact.law")) found = word_of(study.contact.law.values.at(0));
    if (key.name == std::string("reduction.exact_modes")) found = study.exact_modes ? "true" : "false"; // not shown
    if (std::isdigit(wanted.front()))
      EXPECT_EQ(std::stod(wanted), std::stod(found)) << key.name;
    else
      EXPECT_EQ(wanted, found) << key.name;
    ++checked;
  }
  EXPECT_GT(checked, 20);
}

TEST_F(Keys, what_is_required_is_missed) {
  for (const auto &[key, value] : smallest) {
    const std::string why = complaint(key, "");
    EXPECT_NE(why.find(key + " is missing"), std::string::npos) << key << ": " << why;
    EXPECT_EQ(key_named(key)->standard, std::string("required"));
  }
}

TEST_F(Keys, of_lists_of_tables_too) {
  const auto load = [&](const std::string &pattern, const std::string &fourier) {
    return complaint("excitation.load", "[{pattern = " + pattern + ", fourier = " + fourier + "}]");
  };
  EXPECT_EQ(load("\"force\"", "[1, 1.25, 1.3]"), "");
  const Key &pattern = *key_named("excitation.load.pattern"), &fourier = *key_named("excitation.load.fourier");
  for (const std::string &bad : bad_values(pattern))
    EXPECT_NE(load(bad, "[0, 1]").find(pattern.name), std::string::npos) << bad;
  for (const std::string &bad : bad_values(fourier))
    EXPECT_NE(load("\"force\"", bad).find(fourier.name), std::string::npos) << bad;
  EXPECT_NE(complaint("excitation.load", "[{fourier = [0, 1]}]").find("pattern is missing"), std::string::npos);
}

} // namespace
} // namespace dovetail
