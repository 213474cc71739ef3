#pragma once
// The keys of the case file, once: the parser takes what this table allows and refuses all others, the schema for
// editors is made of it, and describe() prints the keys in this order.
#include <string>
#include <vector>

#include "case/value.hpp"

namespace dovetail {

struct Case;

struct Key {
  const char *name; ///< "title" or "section.name"
  const char *unit;
  Value value;
  const char *standard; ///< the default, as it would be written in the file; or in words; or "required"
  const char *help;     ///< one line
  std::string (*text)(const Case &study); ///< the value in force, empty where the key has no meaning for this case

  bool has_standard_value() const; ///< `standard` is no words
};

/// Those of [contact] have no text, they depend on the model too; nor have those of lists of tables,
/// "section.list.name".
const std::vector<Key> &keys();

/// Null where there is none of that name.
const Key *key_named(const std::string &name);

/// A JSON schema (draft 7) of the case file, for editors.
std::string case_schema();

} // namespace dovetail
