// The table of keys as a JSON schema: editors complete keys and words by it, and show help, unit and default.
#include <algorithm>
#include <cmath>

#include "case/keys.hpp"
#include "case/number_text.hpp"
#include "support/json.hpp"

namespace dovetail {
namespace {

using Kind = Value::Kind;
using Shape = Value::Shape;

std::string enum_of(const Value &value) {
  std::string list;
  for (const std::string &word : value.words) list += (list.empty() ? "" : ", ") + quoted(word);
  return "\"enum\": [" + list + "]";
}

std::string bounds_of(const Value &value) {
  std::string out;
  const auto add = [&](const char *name, double bound) {
    if (std::abs(bound) < most_whole) out += ", \"" + std::string(name) + "\": " + number_text(bound);
  };
  add(value.open_low ? "exclusiveMinimum" : "minimum", value.low);
  add(value.open_high ? "exclusiveMaximum" : "maximum", value.high);
  return out;
}

// One such value, without braces.
std::string single(const Value &value) {
  switch (value.kind) {
  case Kind::text:
    return "\"type\": \"string\", \"minLength\": 1";
  case Kind::truth:
    return "\"type\": \"boolean\"";
  case Kind::number:
    return "\"type\": \"number\"" + bounds_of(value);
  case Kind::whole:
    return "\"type\": \"integer\"" + bounds_of(value);
  case Kind::word:
    return enum_of(value);
  case Kind::node:
    return "\"type\": [\"string\", \"integer\"]" + bounds_of(value);
  case Kind::tables:
    break;
  }
  return "";
}

std::string list_of(const std::string &items, const std::string &length = "") {
  return "\"type\": \"array\"" + length + ", \"items\": {" + items + "}";
}

std::string any_of(const std::vector<std::string> &ways) {
  std::string out;
  for (const std::string &way : ways) out += (out.empty() ? "{" : ", {") + way + "}";
  return "\"anyOf\": [" + out + "]";
}

const std::string two = ", \"minItems\": 2, \"maxItems\": 2", some = ", \"minItems\": 1";

std::string shaped(const Value &value) {
  const std::string one = single(value);
  switch (value.shape) {
  case Shape::one:
    return one;
  case Shape::list:
    return list_of(one);
  case Shape::pair:
    return list_of(one, two);
  case Shape::one_or_list:
    return any_of({one, list_of(one, some)});
  case Shape::one_or_pairs:
    return any_of({one, list_of(one, some), list_of(list_of(one, two), some)});
  case Shape::ratios:
    return list_of("\"type\": \"array\"" + two + ", \"items\": [{" + single(whole(1)) + "}, {" + one + "}]", some);
  }
  return one;
}

std::string properties_of(const std::string &section, bool needs_all);

std::string property(const Key &key) {
  const std::string name = key.name, unit = key.unit == std::string("-") ? "" : key.unit, standard = key.standard;
  std::string out = "\"description\": " + quoted(std::string(key.help) + (unit.empty() ? "" : " [" + unit + "]") +
                                                 (standard.rfind("required", 0) == 0 ? "; " : "; default ") + standard);
  if (!unit.empty()) out += ", \"x-unit\": " + quoted(unit);
  out += ", \"x-default\": " + quoted(standard);
  if (key.has_standard_value()) out += ", \"default\": " + standard;
  if (key.value.kind == Kind::tables) return out + ", " + list_of(properties_of(name, true), some);
  const bool or_word = key.value.kind != Kind::word && !key.value.words.empty();
  return out + ", " + (or_word ? any_of({enum_of(key.value), shaped(key.value)}) : shaped(key.value));
}

// Of a table, without braces. `needs_all`: of what the table of keys says that it is required.
std::string properties_of(const std::string &section, bool needs_all) {
  std::string inside, required;
  for (const Key &key : keys()) {
    const std::string name = key.name;
    if (name.rfind(section + ".", 0) != 0 || name.find('.', section.size() + 1) != std::string::npos) continue;
    const std::string last = quoted(name.substr(section.size() + 1));
    inside += (inside.empty() ? "\n      " : ",\n      ") + last + ": {" + property(key) + "}";
    if (key.standard == std::string("required")) required += (required.empty() ? "" : ", ") + last;
  }
  return "\"type\": \"object\", \"additionalProperties\": false" +
         (needs_all ? ", \"required\": [" + required + "]" : std::string()) + ", \"properties\": {" + inside + "}";
}

} // namespace

std::string case_schema() {
  std::string top;
  std::vector<std::string> sections;
  for (const Key &key : keys()) {
    const std::string name = key.name, section = name.substr(0, name.find('.'));
    if (std::find(sections.begin(), sections.end(), section) != sections.end()) continue;
    sections.push_back(section);
    top += (top.empty() ? "\n    " : ",\n    ") + quoted(section) + ": {" +
           (section == name ? property(key) : properties_of(section, false)) + "}";
  }
  return "{\n  \"$schema\": \"http://json-schema.org/draft-07/schema#\",\n"
         "  \"title\": \"case file of dovetail\",\n"
         "  \"type\": \"object\",\n  \"additionalProperties\": false,\n"
         "  \"oneOf\": [{\"required\": [\"model\"]}, {\"required\": [\"reduced\"]}],\n"
         "  \"required\": [\"excitation\"],\n"
         "  \"properties\": {" +
         top + "\n  }\n}\n";
}

} // namespace dovetail
