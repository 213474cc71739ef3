#pragma once
// What may stand behind a key of the case file: its kind, shape, bounds and words.
#include <limits>
#include <string>
#include <vector>

namespace dovetail {

struct Value {
  enum class Kind { text, truth, number, whole, word, node, tables };
  enum class Shape {
    one,
    list,
    pair,         ///< [from, to]
    one_or_list,  ///< of all contact points, or of each
    one_or_pairs, ///< likewise, where each may have two: t1, t2
    ratios        ///< [[mode, ratio], ...]; bounds are those of the ratio
  };

  Kind kind = Kind::text;
  Shape shape = Shape::one;
  double low = -std::numeric_limits<double>::infinity(), high = -low;
  bool open_low = false, open_high = false; ///< the bound itself is refused
  std::vector<std::string> words = {};      ///< to choose from; of another kind: words that may stand in its place

  Value as(Shape other) const {
    Value out = *this;
    out.shape = other;
    return out;
  }
  Value or_word(const std::string &word) const {
    Value out = *this;
    out.words = {word};
    return out;
  }
  bool has_word(const std::string &word) const;
  std::string words_text() const;        ///< "a", "b" or "c", in quotes
  std::string fault(double value) const; ///< "must be greater than 0"; empty within the bounds
};

constexpr int most_whole = 1000000000; ///< far beyond any use; products of sizes stay within the range of numbers

inline Value text() { return {}; }
inline Value truth() { return {Value::Kind::truth}; }
inline Value node() { return {Value::Kind::node, Value::Shape::one, 0, most_whole}; } ///< a set, or the row of a node
inline Value tables() { return {Value::Kind::tables}; }
inline Value number() { return {Value::Kind::number}; }
Value positive(double below = std::numeric_limits<double>::infinity());
Value not_negative(double most = std::numeric_limits<double>::infinity());
Value whole(int low, int high = most_whole);
Value word(std::vector<std::string> words);

} // namespace dovetail
