#include "case/screening.hpp"

#include <algorithm>
#include <cstdio>

#include "support/error.hpp"

namespace dovetail {
namespace {

constexpr int deepest = 32;              // brackets within brackets, or parts of a dotted key
constexpr int most_keys = 1000;          // with the headings of sections
constexpr size_t longest_line = 100'000; // characters, read in a second

/// Length of the character that begins at `at`, 0 if there is none (RFC 3629: no overlong forms, no surrogates).
size_t utf8_length(const std::string &text, size_t at) {
  const auto byte = [&](size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u; };
  const unsigned head = byte(at);
  const size_t length = head < 0x80 ? 1 : head < 0xC2 ? 0 : head < 0xE0 ? 2 : head < 0xF0 ? 3 : head < 0xF5 ? 4 : 0;
  for (size_t i = 1; i < length; ++i)
    if (byte(at + i) >> 6 != 2) return 0;
  const unsigned next = byte(at + 1);
  const bool wrong = (head == 0xE0 && next < 0xA0) || (head == 0xED && next > 0x9F) || (head == 0xF0 && next < 0x90) ||
                     (head == 0xF4 && next > 0x8F);
  return wrong ? 0 : length;
}

/// The last place of the string that begins at `at`, or the one before the end of the comment; `at` if neither does.
size_t skip(const std::string &text, size_t at) {
  const char quote = text[at];
  if (quote == '#') return std::min(text.find('\n', at), text.size()) - 1;
  if (quote != '"' && quote != '\'') return at;
  const bool lines = text.compare(at, 3, std::string(3, quote)) == 0;
  for (size_t i = at + (lines ? 3 : 1); i < text.size(); ++i) {
    if (quote == '"' && text[i] == '\\')
      ++i;
    else if (!lines && (text[i] == quote || text[i] == '\n'))
      return text[i] == '\n' ? i - 1 : i;
    else if (lines && text.compare(i, 3, std::string(3, quote)) == 0)
      return std::min(text.find_first_not_of(quote, i), text.size()) - 1; // up to two quotes belong to the string
  }
  return text.size() - 1;
}

class Screen {
public:
  Screen(const std::string &file, const std::string &text) : file_(file), text_(text) {}

  void characters() {
    size_t line = 1, begin = 0;
    for (size_t at = 0, length = 0; at < text_.size(); at += length) {
      length = utf8_length(text_, at);
      if (length == 0) {
        char byte[8];
        std::snprintf(byte, sizeof byte, "0x%02X", static_cast<unsigned char>(text_[at]));
        refuse(line, std::string("byte ") + byte + " is not UTF-8 text; save the file as UTF-8");
      }
      if (at - begin > longest_line)
        refuse(line, "more than " + std::to_string(longest_line) + " characters; break the list into several lines");
      if (text_[at] == '\n') ++line, begin = at + 1;
    }
  }

  void nesting() {
    size_t line = 1;
    int depth = 0, dots = 0, keys = 0;
    for (size_t at = 0; at < text_.size(); ++at) {
      const size_t end = skip(text_, at);
      if (end != at) {
        line += static_cast<size_t>(std::count(text_.begin() + at, text_.begin() + end, '\n'));
        at = end;
        continue;
      }
      const char c = text_[at];
      const bool opens = c == '[' || c == '{', closes = c == ']' || c == '}';
      if (c == '\n') ++line;
      if (c == '=' || (opens && depth == 0)) ++keys;
      depth += opens - closes;
      dots = c == '.' ? dots + 1 : opens || closes || c == '=' || c == ',' || c == '\n' ? 0 : dots;
      if (std::max(depth, dots) > deepest) refuse(line, "more than " + std::to_string(deepest) + " levels");
      if (keys > most_keys) refuse(line, "more than " + std::to_string(most_keys) + " keys");
    }
  }

private:
  [[noreturn]] void refuse(size_t line, const std::string &what) const {
    throw InputError(file_ + ":" + std::to_string(line) + ": " + what);
  }
  const std::string &file_, &text_;
};

} // namespace

void screen(const std::string &file, const std::string &text) {
  Screen screen(file, text);
  screen.characters();
  screen.nesting();
}

} // namespace dovetail
