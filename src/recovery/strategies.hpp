#pragma once
// What may be tried where steps along a curve lead nowhere, or where no first point is found: by name, in an order.
#include <algorithm>
#include <string>
#include <vector>

namespace dovetail {

class RecoveryStrategy; // recovery/recovery.hpp

const RecoveryStrategy &fewer_harmonics(), &jump(), &integration(), &elsewhere();

struct Strategy {
  const char *name;                    ///< as in [recovery] strategies
  bool may_change_branch;              ///< what comes may lie on another branch
  const RecoveryStrategy &(*object)(); ///< defined in a file of its own
};

/// In the order in which they are tried by default.
inline constexpr Strategy all_strategies[] = {
    {"fewer_harmonics", false, fewer_harmonics}, // a first point from that with fewer harmonics
    {"jump", true, jump},               // the solution at a next frequency, by Newton's method from here or rest
    {"integration", true, integration}, // the steady state there, or at the first frequency, by time integration
    {"elsewhere", false, elsewhere},    // a first point at another frequency of the sweep
};

/// A list without repetition, in the order in which they are tried.
class Strategies {
public:
  static Strategies all() {
    Strategies out;
    for (const Strategy &one : all_strategies) out.list_.push_back(&one);
    return out;
  }
  bool none() const { return list_.empty(); }
  const std::vector<const Strategy *> &list() const { return list_; }
  /// False if it is in the list.
  bool add(const Strategy *one) {
    if (std::find(list_.begin(), list_.end(), one) != list_.end()) return false;
    list_.push_back(one);
    return true;
  }
  bool has(const std::string &name) const { return std::find(list_.begin(), list_.end(), named(name)) != list_.end(); }
  void remove(const std::string &name) {
    list_.erase(std::remove(list_.begin(), list_.end(), named(name)), list_.end());
  }
  /// Without those that may change the branch.
  void keep_branch() {
    const auto may = [](const Strategy *one) { return one->may_change_branch; };
    list_.erase(std::remove_if(list_.begin(), list_.end(), may), list_.end());
  }

  /// Null: there is none of that name.
  static const Strategy *named(const std::string &name) {
    for (const Strategy &one : all_strategies)
      if (name == one.name) return &one;
    return nullptr;
  }
  /// As in the case file.
  std::string text() const {
    std::string out;
    for (const Strategy *one : list_) out += (out.empty() ? "" : ", ") + std::string(one->name);
    return out.empty() ? "none" : out;
  }

private:
  std::vector<const Strategy *> list_;
};

} // namespace dovetail
