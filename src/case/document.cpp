#include "case/document.hpp"

#include <cmath>
#include <limits>
#include <sstream>

#include "case/screening.hpp"
#include "support/error.hpp"

namespace dovetail {
namespace {

std::string shorten(const std::string &text, size_t length = 60) {
  return text.size() <= length ? text : text.substr(0, length) + " ...";
}

/// toml11 draws its message over several lines, with a caret below the culprit; this keeps the headline and
/// the last remark beside a caret, without the name of the parser's function.
std::string condense(const std::string &drawing) {
  std::istringstream lines(drawing);
  std::string headline, line, remark;
  std::getline(lines, headline);
  while (std::getline(lines, line))
    for (const std::string mark : {"^--- ", "~~ "})
      if (const auto at = line.rfind(mark); at != std::string::npos) remark = line.substr(at + mark.size());
  if (const std::string tag = "[error] "; headline.rfind(tag, 0) == 0) headline.erase(0, tag.size());
  if (headline.rfind("toml::", 0) == 0)
    if (const auto colon = headline.find(':', 6); colon != std::string::npos) headline.erase(0, colon + 2);
  // What it says of words without quotes depends on their first letter ("not a boolean" for five).
  if (headline.empty() || headline == "bad format: unknown value appeared")
    return "unknown value; text needs quotes, a switch is true or false";
  if (headline.back() == '.') headline.pop_back();
  return headline + (remark.empty() || remark == "here" ? "" : " (" + remark + ")");
}

toml::value parse(const std::string &file, const std::string &text) {
  screen(file, text);
  std::istringstream stream(text);
  try {
    return toml::parse(stream, file);
  } catch (const TomlError &error) {
    const TextPlace at = place_of(error);
    throw InputError(file + ":" + std::to_string(at.line) + ": " + shorten(at.text) + ": " +
                     condense(drawing_of(error)));
  } catch (const std::exception &error) { // toml11 lets a few standard exceptions through, without a place
    throw InputError(file + ": not a TOML file: " + condense(error.what()));
  }
}

} // namespace

Entry::Entry(std::string file, std::string name, const toml::value *value, const Key *key)
    : file_(std::move(file)), name_(std::move(name)), value_(value), key_(key) {}

std::string Entry::source() const {
  const TextPlace at = place_of(*value_);
  const std::string rest = at.column <= at.text.size() ? at.text.substr(at.column - 1) : "";
  // A value over several lines is cut at the end of its first one.
  return at.length > rest.size() ? shorten(rest) + " ..." : shorten(rest.substr(0, at.length));
}

void Entry::refuse(const std::string &why) const { throw InputError(where() + " = " + source() + ": " + why); }

double Entry::finite() const {
  double result = 0;
  if (value_->is_integer()) {
    const auto whole = value_->as_integer();
    // toml11 cuts what does not fit without a word; nobody means these two values.
    using Limits = std::numeric_limits<toml::value::integer_type>;
    if (whole == Limits::max() || whole == Limits::min()) refuse("too many digits; write it with an exponent, as 1e20");
    result = static_cast<double>(whole);
  } else if (value_->is_floating()) {
    result = value_->as_floating();
  } else {
    refuse(value_->is_string() ? "must be a number; write it without quotes" : "must be a number");
  }
  // 1e999 arrives as the largest double.
  if (!(std::abs(result) < std::numeric_limits<double>::max())) refuse("must be a finite number");
  return result;
}

double Entry::number(const std::string &besides) const {
  const double result = finite();
  if (const std::string fault = key_->value.fault(result); !fault.empty()) refuse(fault + besides);
  return result;
}

int Entry::whole(const Value &allowed) const {
  if (value_->is_floating()) {
    const double found = value_->as_floating();
    const bool fits = found == std::floor(found) && std::abs(found) <= most_whole && allowed.fault(found).empty();
    refuse("must be a whole number" + (fits ? "; write " + std::to_string(static_cast<int>(found)) : ""));
  }
  if (!value_->is_integer())
    refuse(value_->is_string() ? "must be a whole number; write it without quotes" : "must be a whole number");
  const auto found = value_->as_integer();
  if (const std::string fault = allowed.fault(static_cast<double>(found)); !fault.empty()) refuse(fault);
  return static_cast<int>(found);
}

bool Entry::truth() const {
  if (!value_->is_boolean()) refuse("must be true or false, without quotes");
  return value_->as_boolean();
}

std::string Entry::words() const {
  if (!value_->is_string()) refuse("must be text in quotes");
  const std::string &result = text_of(*value_);
  if (result.empty()) refuse("is empty; write something between the quotes, or leave the key out");
  return result;
}

std::string Entry::word(const std::string &besides) const {
  const std::string found = is_words() ? text_of(*value_) : "";
  if (!key_->value.has_word(found)) refuse("must be " + key_->value.words_text() + besides);
  return found;
}

std::vector<Entry> Entry::items() const {
  if (!is_list()) refuse("must be a list in brackets, as [1.0, 2.0]");
  std::vector<Entry> result;
  for (const auto &item : value_->as_array())
    result.emplace_back(file_, "entry " + std::to_string(result.size() + 1) + " of " + name_, &item, key_);
  return result;
}

std::vector<Entry> Entry::tables(const std::string &wanted) const {
  std::vector<Entry> result;
  if (is_list())
    for (const auto &item : value_->as_array())
      if (item.is_table()) result.emplace_back(file_, name_, &item);
  if (result.empty() || result.size() != value_->as_array().size()) throw InputError(where() + ": write " + wanted);
  return result;
}

Entry Entry::operator[](const std::string &key) const {
  const auto found = value_->as_table().find(key);
  const std::string name = name_ + "." + key;
  return {file_, name, found == value_->as_table().end() ? nullptr : &found->second, key_named(name)};
}

std::vector<double> Entry::numbers() const {
  std::vector<double> result;
  for (const auto &item : items()) result.push_back(item.number());
  return result;
}

Document::Document(const std::filesystem::path &file, const std::string &text)
    : file_(file.string()), root_(parse(file_, text)) {}

Entry Document::operator[](const std::string &key) const {
  const auto inside = [](const toml::value *table, const std::string &name) -> const toml::value * {
    if (!table || !table->is_table()) return nullptr;
    const auto found = table->as_table().find(name);
    return found == table->as_table().end() ? nullptr : &found->second;
  };
  const auto dot = key.find('.');
  const toml::value *value = inside(&root_, key.substr(0, dot));
  return {file_, key, dot == std::string::npos ? value : inside(value, key.substr(dot + 1)), key_named(key)};
}

void Document::missing(const std::string &key, const std::string &example) const {
  const auto dot = key.find('.');
  const std::string section = dot == std::string::npos ? "" : key.substr(0, dot);
  const Entry heading = (*this)[section.empty() ? key : section];
  throw InputError((heading ? heading.place() : file_) + ": " + key + " is missing: write " + example +
                   (section.empty() ? " above the first section" : " under [" + section + "]"));
}

} // namespace dovetail
