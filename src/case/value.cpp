#include "case/value.hpp"

#include <algorithm>
#include <cmath>

#include "case/number_text.hpp"

namespace dovetail {

bool Value::has_word(const std::string &word) const {
  return std::find(words.begin(), words.end(), word) != words.end();
}

std::string Value::words_text() const {
  std::string out;
  for (std::size_t i = 0; i < words.size(); ++i)
    out += (i == 0 ? "\"" : i + 1 == words.size() ? " or \"" : ", \"") + words[i] + '"';
  return out;
}

std::string Value::fault(double value) const {
  // Of whole numbers text with an exponent would be odd.
  const auto in_words = [&](double bound) {
    return kind == Kind::whole ? std::to_string(static_cast<long>(bound)) : number_text(bound);
  };
  const bool low_fails = open_low ? value <= low : value < low, high_fails = open_high ? value >= high : value > high;
  if (!low_fails && !high_fails) return "";
  if (open_low && open_high && std::isfinite(high))
    return "must be greater than " + in_words(low) + " and less than " + in_words(high);
  if (high_fails) return "must be at most " + in_words(high);
  return open_low                          ? "must be greater than " + in_words(low)
         : low == 0 && kind != Kind::whole ? "must not be negative"
                                           : "must be at least " + in_words(low);
}

Value positive(double below) { return {Value::Kind::number, Value::Shape::one, 0, below, true, std::isfinite(below)}; }

Value not_negative(double most) { return {Value::Kind::number, Value::Shape::one, 0, most}; }

Value whole(int low, int high) {
  return {Value::Kind::whole, Value::Shape::one, static_cast<double>(low), static_cast<double>(high)};
}

Value word(std::vector<std::string> words) {
  Value out;
  out.kind = Value::Kind::word, out.words = std::move(words);
  return out;
}

} // namespace dovetail
