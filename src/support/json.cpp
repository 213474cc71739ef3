#include "support/json.hpp"

#include <cmath>
#include <cstdio>

namespace dovetail {
namespace {

// How many bytes the letter that begins here takes; 0 where it is no UTF-8.
std::size_t length_of_letter(const std::string &text, std::size_t at) {
  const auto byte = [&](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u; };
  const unsigned first = byte(at), second = byte(at + 1);
  const std::size_t length = first < 0x80   ? 1
                             : first < 0xc2 ? 0
                             : first < 0xe0 ? 2
                             : first < 0xf0 ? 3
                             : first < 0xf5 ? 4
                                            : 0;
  for (std::size_t i = 1; i < length; ++i)
    if ((byte(at + i) & 0xc0) != 0x80) return 0;
  const bool beyond = (first == 0xe0 && second < 0xa0) || (first == 0xed && second >= 0xa0) || // too long; a surrogate
                      (first == 0xf0 && second < 0x90) || (first == 0xf4 && second >= 0x90);
  return beyond ? 0 : length;
}

} // namespace

std::string quoted(const std::string &text) {
  std::string out = "\"";
  for (std::size_t at = 0, length; at < text.size(); at += length ? length : 1) {
    length = length_of_letter(text, at);
    const char letter = text[at];
    char escaped[8];
    if (letter == '"' || letter == '\\')
      (out += '\\') += letter;
    else if (length == 1 && letter < 0x20)
      std::snprintf(escaped, sizeof escaped, "\\u%04x", letter), out += escaped;
    else
      out += length ? text.substr(at, length) : "?";
  }
  return out + "\"";
}

std::string json_number(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.17g", value);
  return std::isfinite(value) ? text : "null";
}

} // namespace dovetail
