#pragma once
// What may be tried where steps along a curve lead nowhere, or where no first point is found: by name, one by one.
#include <array>
#include <bitset>
#include <optional>
#include <string>

namespace dovetail {

enum class Strategy {
  repeat,
  sampling,
  harmonics,
  jump,
  integration,
  in_time,
  restart,
  other_end,
  multistart,
  fewer_harmonics,
  soft_contacts,
  load,
  elsewhere,
};

struct StrategyAbout {
  Strategy which;
  const char *name;       ///< as in [recovery] strategies
  bool may_change_branch; ///< what comes may lie on another branch
};

/// In the order in which they are tried, whatever the order in the case file; those for a first point come last.
inline constexpr std::array<StrategyAbout, 13> all_strategies{{
    {Strategy::repeat, "repeat", false},       // the last points once more, with short steps
    {Strategy::sampling, "sampling", false},   // contact forces exactly instead of by samples
    {Strategy::harmonics, "harmonics", false}, // more harmonics
    {Strategy::jump, "jump", true}, // the solution at a next frequency, by Newton's method from the last point
    {Strategy::integration, "integration", true}, // the steady state at a next frequency, by time integration
    {Strategy::in_time, "in_time", true},         // the curve of periodic motions in time from there
    {Strategy::restart, "restart", true},         // the solution at a next frequency, found as a first point is
    {Strategy::other_end, "other_end", true},     // the rest of the sweep, from its other end
    {Strategy::multistart, "multistart", true},   // frequencies all over the rest of the sweep
    {Strategy::fewer_harmonics, "fewer_harmonics", false}, // a first point from that with fewer harmonics
    {Strategy::soft_contacts, "soft_contacts", false},     // a first point from that with softer contacts
    {Strategy::load, "load", false},                       // a first point by a load that grows from nothing
    {Strategy::elsewhere, "elsewhere", false},             // a first point at another frequency of the sweep
}};

class Strategies {
public:
  static Strategies all() {
    Strategies out;
    out.set_.set();
    return out;
  }
  bool has(Strategy which) const { return set_[static_cast<std::size_t>(which)]; }
  bool none() const { return set_.none(); }
  void add(Strategy which) { set_.set(static_cast<std::size_t>(which)); }
  /// Without those that may change the branch.
  void keep_branch() {
    for (const StrategyAbout &about : all_strategies)
      if (about.may_change_branch) set_.reset(static_cast<std::size_t>(about.which));
  }

  /// Without those that integrate in time.
  void keep_harmonic_balance() {
    for (const Strategy which : {Strategy::integration, Strategy::in_time}) set_.reset(static_cast<std::size_t>(which));
  }

  static std::optional<Strategy> named(const std::string &name) {
    for (const StrategyAbout &about : all_strategies)
      if (name == about.name) return about.which;
    return std::nullopt;
  }
  /// As in the case file.
  std::string text() const {
    if (set_.all()) return "all";
    std::string out;
    for (const StrategyAbout &about : all_strategies)
      if (has(about.which)) out += (out.empty() ? "" : ", ") + std::string(about.name);
    return out.empty() ? "none" : out;
  }

private:
  std::bitset<all_strategies.size()> set_;
};

} // namespace dovetail
