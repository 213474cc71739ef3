#pragma once
// The keys of the case file, once: the parser refuses all others, describe() prints them in this order.
#include <string>
#include <vector>

#include "case/case.hpp"

namespace dovetail {

struct Key {
  const char *name; ///< "title" or "section.name"
  const char *unit;
  std::string (*text)(const Case &study); ///< the value in force, empty where the key has no meaning for this case
};

/// Those of [contact] have no text, they depend on the model too; nor have those of lists of tables,
/// "section.list.name".
const std::vector<Key> &keys();

} // namespace dovetail
