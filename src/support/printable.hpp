#pragma once
// Text out of files of others on its way to a terminal.
#include <string>

namespace dovetail {

/// The text with a question mark for each byte that is a command to a terminal.
inline std::string printable(std::string text) {
  for (char &letter : text) {
    const auto byte = static_cast<unsigned char>(letter);
    if ((byte < 0x20 && letter != '\n' && letter != '\t') || byte == 0x7f) letter = '?';
  }
  return text;
}

} // namespace dovetail
