#include <algorithm>
#include <limits>
#include <numeric>
#include <set>

#include "case/document.hpp"
#include "support/error.hpp"

namespace dovetail {
namespace {

/// Insertions, deletions, replacements and swaps of neighbours that lead from one word to the other.
size_t edit_distance(const std::string &from, const std::string &to) {
  std::vector<std::vector<size_t>> cost(from.size() + 1, std::vector<size_t>(to.size() + 1));
  for (size_t i = 0; i <= from.size(); ++i) cost[i][0] = i;
  std::iota(cost[0].begin(), cost[0].end(), size_t{0});
  for (size_t i = 1; i <= from.size(); ++i)
    for (size_t j = 1; j <= to.size(); ++j) {
      const size_t replaced = cost[i - 1][j - 1] + (from[i - 1] != to[j - 1]);
      cost[i][j] = std::min({cost[i - 1][j] + 1, cost[i][j - 1] + 1, replaced});
      if (i > 1 && j > 1 && from[i - 1] == to[j - 2] && from[i - 2] == to[j - 1])
        cost[i][j] = std::min(cost[i][j], cost[i - 2][j - 2] + 1);
    }
  return cost[from.size()][to.size()];
}

struct Name {
  std::string section, key; ///< section empty: above the first one; key empty: the section itself
};

Name split(const std::string &dotted) {
  const auto dot = dotted.rfind('.');
  return dot == std::string::npos ? Name{"", dotted} : Name{dotted.substr(0, dot), dotted.substr(dot + 1)};
}

std::string heading(const std::string &section) { // of a list of tables, if it has a dot
  return section.find('.') == std::string::npos ? "[" + section + "]" : "[[" + section + "]]";
}

std::string spelled(const Name &name) {
  if (name.key.empty()) return heading(name.section);
  return name.key + (name.section.empty() ? " above the first section" : " in " + heading(name.section));
}

/// Words between underscores: "stiffness" is one of "normal_stiffness".
bool has_word(const std::string &name, const std::string &word) {
  return ("_" + name + "_").find("_" + word + "_") != std::string::npos;
}

/// The allowed names most like `word`: those of `section` with that word in them, all of them; else the nearest, where
/// a namesake in `section` comes before equals elsewhere. Empty: none is alike.
std::vector<Name> suggestions(const std::string &word, const std::string &section, const std::vector<Name> &allowed) {
  std::vector<Name> result;
  for (const auto &name : allowed)
    if (name.section == section && has_word(name.key, word)) result.push_back(name);
  if (!result.empty()) return result;
  size_t best = 2 * std::max<size_t>(1, word.size() / 3) + 2; // beyond one change in three letters it is another word
  for (const auto &name : allowed) {
    const size_t away = name.section != section;
    const size_t distance = 2 * edit_distance(word, name.key.empty() ? name.section : name.key) + away;
    if (distance < best) best = distance, result = {name};
  }
  return result;
}

std::string in_words(const std::vector<Name> &names) {
  std::string result;
  for (const auto &name : names) result += (result.empty() ? "" : " or ") + spelled(name);
  return result;
}

std::string listed(const std::string &section, const std::vector<Name> &allowed) {
  std::string result;
  for (const auto &name : allowed)
    if (name.section == section && !name.key.empty()) result += (result.empty() ? "" : ", ") + name.key;
  return result;
}

} // namespace

void Document::refuse_unknown(const std::vector<std::string> &allowed) const {
  std::vector<Name> names;
  std::vector<Name> sections;
  for (const auto &dotted : allowed) {
    names.push_back(split(dotted));
    const std::string &section = names.back().section;
    if (!section.empty() && (sections.empty() || sections.back().section != section)) sections.push_back({section, ""});
  }
  const std::set<std::string> known(allowed.begin(), allowed.end());
  const auto is_section = [&](const std::string &word) {
    return std::any_of(sections.begin(), sections.end(), [&](const Name &name) { return name.section == word; });
  };

  // toml11 keeps its tables unordered: of all complaints, the one that comes first in the file is made.
  std::pair<size_t, std::string> first{std::numeric_limits<size_t>::max(), ""};
  const auto complain = [&](const toml::value &at, const std::string &message) {
    const size_t line = place_of(at).line;
    if (line < first.first) first = {line, file_ + ":" + std::to_string(line) + ": " + message};
  };
  const auto unknown_key = [&](const Entry &entry, const toml::value &value, const Name &name) {
    const auto alike = suggestions(name.key, name.section, names);
    const std::string place = name.section.empty() ? "above the first section" : "in " + heading(name.section);
    const std::string all = "allowed " + place + ": " + listed(name.section, names);
    const bool elsewhere = !alike.empty() && alike.front().section != name.section;
    complain(value, "unknown key " + (name.section.empty() ? "" : name.section + ".") + name.key + " = " +
                        entry.source() + ": " +
                        (alike.empty() ? all : "did you mean " + in_words(alike) + "?" + (elsewhere ? " " + all : "")));
  };

  const auto unknown_in_list = [&](const toml::value &item, const std::string &list) {
    if (!item.is_table()) return;
    for (const auto &[key, inner] : item.as_table())
      if (!known.count(list + "." + key)) unknown_key(Entry(file_, key, &inner), inner, {list, key});
  };

  for (const auto &[word, value] : root_.as_table()) {
    if (is_section(word)) {
      if (!value.is_table())
        complain(value, word + " is a section: write [" + word + "] on a line of its own, once");
      else
        for (const auto &[key, inner] : value.as_table())
          if (!known.count(word + "." + key))
            unknown_key(Entry(file_, key, &inner), inner, {word, key});
          else if (inner.is_array())
            for (const auto &item : inner.as_array()) unknown_in_list(item, word + "." + key);
    } else if (value.is_table() && !known.count(word)) {
      const std::string alike = in_words(suggestions(word, "", sections));
      std::string all;
      for (const auto &name : sections) all += (all.empty() ? "" : ", ") + spelled(name);
      complain(value, "unknown section [" + word +
                          "]: " + (alike.empty() ? "the sections are " + all : "did you mean " + alike + "?"));
    } else if (!known.count(word)) {
      unknown_key(Entry(file_, word, &value), value, {"", word});
    }
  }
  if (!first.second.empty()) throw InputError(first.second);
}

} // namespace dovetail
