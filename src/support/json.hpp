#pragma once
// Pieces of JSON text.
#include <string>

namespace dovetail {

/// As a JSON string; a question mark for what is no UTF-8.
std::string quoted(const std::string &text);

/// With all digits; null where it is not finite, for JSON has no other numbers.
std::string json_number(double value);

/// A member of an object behind another one, as in `, "omega": 1.5`.
inline std::string member(const char *name, const std::string &json) {
  return std::string(", \"") + name + "\": " + json;
}
inline std::string member(const char *name, double value) { return member(name, json_number(value)); }
inline std::string member(const char *name, int value) { return member(name, std::to_string(value)); }

} // namespace dovetail
