#pragma once
// toml11 in the versions that distributions have: 3, as in Debian 12, and 4, as in Debian 13.
#include <array>
#include <string>
#include <toml.hpp>
#include <utility>

namespace dovetail {

/// Where something stands in the text. Lines and columns are counted from 1.
struct TextPlace {
  std::size_t line, column, length;
  std::string text; ///< its line
};

#if TOML11_VERSION_MAJOR < 4

using TomlError = toml::exception;
inline TextPlace place_of(const toml::source_location &at) {
  return {at.line(), at.column(), at.region(), at.line_str()};
}
inline TextPlace place_of(const TomlError &error) { return place_of(error.location()); }
inline const std::string &text_of(const toml::value &value) { return value.as_string().str; }
/// A headline, and lines below it; remarks stand behind "^--- " or "~~ ".
inline std::string drawing_of(const TomlError &error) { return error.what(); }

#else

using TomlError = toml::syntax_error;
inline TextPlace place_of(const toml::source_location &at) {
  return {at.first_line_number(), at.first_column_number(), at.length(), at.num_lines() > 0 ? at.first_line() : ""};
}
inline TextPlace place_of(const TomlError &error) { return place_of(error.errors().at(0).locations().at(0).first); }
inline const std::string &text_of(const toml::value &value) { return value.as_string(); }
/// In the words of version 3 where they are plainer.
inline std::string drawing_of(const TomlError &error) {
  static constexpr std::array<std::pair<const char *, const char *>, 9> plainer{{
      {"invalid key value separator", "missing key-value separator `=`\n ^--- should be `=`"},
      {"invalid boolean", "bad format: unknown value appeared"},
      {"integer part is required", "integer part required before decimal point"},
      {"invalid string format", "not a valid string"},
      {"value already exists", "the key already exists\n ^--- defined twice"},
      {"table already defined", "the table already exists"},
      {"expected value-separator", "missing array separator `,`"},
      {"failed to read floating point", "must be a finite number"},
      {"too large integer", "too many digits; write it with an exponent, as 1e20"},
  }};
  const toml::error_info &first = error.errors().at(0);
  for (const auto &[theirs, ours] : plainer)
    if (first.title().find(theirs) != std::string::npos) return ours;
  return first.title() + "\n ^--- " + first.locations().at(0).second;
}

#endif

inline TextPlace place_of(const toml::value &value) { return place_of(value.location()); }

} // namespace dovetail
