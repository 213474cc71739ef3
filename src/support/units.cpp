#include "support/units.hpp"
#include "support/unit_sizes.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>

namespace dovetail {
namespace {

using Sizes = std::map<std::string, double>;

enum Kind { length, mass, time, force, stress, kinds };

// In kg, m, s, N, Pa.
const Sizes &sizes_of(int kind) {
  static const Sizes known[kinds] = {
      {{"m", 1}, {"mm", 1e-3}, {"cm", 1e-2}, {"um", 1e-6}, {"µm", 1e-6}, {"in", 0.0254}, {"ft", 0.3048}},
      {{"kg", 1}, {"g", 1e-3}, {"t", 1e3}, {"tonne", 1e3}, {"Mg", 1e3}, {"slug", 14.593902937206364}},
      {{"s", 1}, {"ms", 1e-3}, {"us", 1e-6}, {"µs", 1e-6}},
      {{"N", 1}, {"kN", 1e3}, {"MN", 1e6}, {"mN", 1e-3}, {"uN", 1e-6}, {"µN", 1e-6}, {"lbf", 4.4482216152605}},
      {{"Pa", 1}, {"kPa", 1e3}, {"MPa", 1e6}, {"GPa", 1e9}, {"psi", 6894.757293168361}}};
  return known[kind];
}

bool same(double a, double b) { return std::abs(a - b) <= 1e-9 * std::max(std::abs(a), std::abs(b)); }

std::string prefixed(double size, const std::string &base) {
  static const std::map<long, std::string> prefixes = {{-12, "p"}, {-9, "n"}, {-6, "µ"}, {-3, "m"},
                                                       {0, ""},    {3, "k"},  {6, "M"},  {9, "G"}};
  const long power = std::lround(std::log10(size));
  const auto found = prefixes.find(power);
  return found != prefixes.end() && same(size, std::pow(10.0, power)) ? found->second + base : "";
}

std::string mass_named(double size) {
  for (const auto &[name, known] : Sizes{{"mg", 1e-6}, {"g", 1e-3}, {"kg", 1}, {"t", 1e3}})
    if (same(size, known)) return name;
  return "";
}

std::string or_else(std::string name, const std::string &other) { return name.empty() ? other : name; }

struct Found {
  std::string names[kinds];
  double sizes[kinds] = {0, 0, 0, 0, 0}; // 0: not given
};

// The words of a label. False where one is not known, or two are of a kind.
bool read(const std::string &label, Found &found) {
  std::string word;
  const auto take = [&] {
    if (word.empty()) return true;
    for (int kind = 0; kind < kinds; ++kind)
      if (const auto size = sizes_of(kind).find(word); size != sizes_of(kind).end()) {
        if (found.sizes[kind] > 0) return false;
        found.sizes[kind] = size->second;
        found.names[kind] = word == "um" ? "µm" : word == "us" ? "µs" : word == "uN" ? "µN" : word;
        word.clear();
        return true;
      }
    return false;
  };
  for (const char c : label)
    if (std::isspace(static_cast<unsigned char>(c)) || c == ',' || c == ';' || c == '/' || c == '-') {
      if (!take()) return false;
    } else {
      word += c;
    }
  return take();
}

// Force = mass length / time^2 gives the fourth of three. False where there are fewer, or it has no name.
bool complete(Found &found) {
  auto &[names, sizes] = found;
  if (std::count(sizes, sizes + stress, 0.0) > 1) return false;
  const double L = sizes[length], M = sizes[mass], T = sizes[time], F = sizes[force];
  if (F == 0) {
    sizes[force] = M * L / (T * T);
    names[force] = or_else(prefixed(sizes[force], "N"), names[mass] + " " + names[length] + "/" + names[time] + "²");
  } else if (M == 0) {
    sizes[mass] = F * T * T / L;
    names[mass] = or_else(mass_named(sizes[mass]), names[force] + " " + names[time] + "²/" + names[length]);
  } else if (L == 0 || T == 0) {
    const int kind = L == 0 ? length : time;
    sizes[kind] = L == 0 ? F * T * T / M : std::sqrt(M * L / F);
    for (const char *name : {"m", "mm", "cm", "µm", "in", "ft", "s", "ms", "µs"})
      if (const auto known = sizes_of(kind).find(name);
          known != sizes_of(kind).end() && same(known->second, sizes[kind]))
        names[kind] = name;
    if (names[kind].empty()) return false;
  }
  const double force_made = sizes[mass] * sizes[length] / (sizes[time] * sizes[time]),
               stress_made = sizes[force] / (sizes[length] * sizes[length]);
  return same(sizes[force], force_made) && (sizes[stress] == 0 || same(sizes[stress], stress_made));
}

bool understand(const std::string &label, Found &found) {
  std::string letters;
  for (const char c : label)
    if (!std::isspace(static_cast<unsigned char>(c))) letters += std::toupper(static_cast<unsigned char>(c));
  return read(letters == "SI" ? "kg, m, s, N" : label, found) && complete(found);
}

} // namespace

Units units_of(const std::string &label) {
  Found found;
  if (!understand(label, found)) return {};
  const auto &[names, sizes] = found;
  Units units;
  units.length = names[length], units.mass = names[mass], units.time = names[time], units.force = names[force];
  units.energy = or_else(prefixed(sizes[force] * sizes[length], "J"), units.force + " " + units.length);
  units.stress =
      or_else(prefixed(sizes[force] / (sizes[length] * sizes[length]), "Pa"), units.force + "/" + units.length + "²");
  const bool one_word = units.mass.find(' ') == std::string::npos;
  units.modal = units.length + " √" + (one_word ? units.mass : "(" + units.mass + ")");
  units.omega = "rad/" + units.time, units.seconds = sizes[time];
  return units;
}

std::optional<UnitSizes> unit_sizes_of(const std::string &label) {
  Found found;
  if (!understand(label, found)) return {};
  return UnitSizes{found.sizes[length], found.sizes[mass], found.sizes[time]};
}

double Units::hertz(double value) const { return value / (2 * M_PI * seconds); }

std::string Units::instead_of(const std::string &unit) const {
  if (unit == "rad/s") return omega;
  if (unit == "m") return length;
  if (unit == "s") return time;
  if (unit == "1/s") return known() ? "1/" + time : "";
  if (unit == "N/m") return known() ? force + "/" + length : "";
  if (unit == "m kg^1/2") return modal;
  return unit;
}

} // namespace dovetail
