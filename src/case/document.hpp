#pragma once
// The TOML file seen through its messages: every value knows its file, line and name, and complains in one
// form,
//   FILE:LINE: key = VALUE: what is wrong; what to write instead
#include <filesystem>
#include <string>
#include <vector>

#include "case/keys.hpp"
#include "case/toml_versions.hpp"

namespace dovetail {

/// One value of the document, or nothing where the key is absent. Borrowed: the Document must outlive it. Numbers and
/// words are refused where the table of keys does not allow them.
class Entry {
public:
  Entry(std::string file, std::string name, const toml::value *value, const Key *key = nullptr);

  explicit operator bool() const { return value_ != nullptr; }
  size_t line() const { return place_of(*value_).line; }
  std::string place() const { return file_ + ":" + std::to_string(line()); } ///< FILE:LINE
  std::string where() const { return place() + ": " + name_; }               ///< FILE:LINE: key
  [[noreturn]] void refuse(const std::string &why) const;                    ///< throws InputError
  std::string source() const; ///< the value as the user wrote it, shortened

  // Strictly typed; each refuses anything else.
  double finite() const; ///< a number, of any size; an integer will do
  /// Likewise, within the bounds of the key. `besides`: what else may be said where it is not.
  double number(const std::string &besides = "") const;
  int whole() const { return whole(key_->value); }
  int whole(const Value &allowed) const; ///< within other bounds than those of the key
  bool truth() const;
  std::string words() const; ///< text, not empty
  /// One of those of the key; `besides`: what else may be said to who has written another.
  std::string word(const std::string &besides = "") const;
  std::vector<double> numbers() const; ///< a list of finite numbers

  bool is_list() const { return value_->is_array(); }
  bool is_words() const { return value_->is_string(); }
  std::vector<Entry> items() const; ///< of a list; they call themselves "entry 3 of KEY"
  /// Of a list of tables; else a refusal that says to write `wanted`.
  std::vector<Entry> tables(const std::string &wanted) const;
  Entry operator[](const std::string &key) const; ///< of a table; "KEY.name"

private:
  std::string file_, name_;
  const toml::value *value_;
  const Key *key_;
};

class Document {
public:
  /// Throws InputError where the text is not TOML.
  Document(const std::filesystem::path &file, const std::string &text);

  /// `key` is "title" or "section.name".
  Entry operator[](const std::string &key) const;

  /// Throws InputError for the first key or section not in `allowed` (spelled as for operator[]), with a
  /// suggestion.
  void refuse_unknown(const std::vector<std::string> &allowed) const;

  /// Throws InputError: `key` is missing, with `example` of what to write.
  [[noreturn]] void missing(const std::string &key, const std::string &example) const;

private:
  std::string file_;
  toml::value root_;
};

} // namespace dovetail
