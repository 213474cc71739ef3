#include <algorithm>
#include <cmath>
#include <iomanip>
#include <limits>
#include <map>
#include <ostream>

#include "case/case.hpp"
#include "case/contact_settings.hpp"
#include "case/keys.hpp"
#include "case/number_text.hpp"

namespace dovetail {
namespace {

struct Row {
  std::string key, value, unit, origin;
};

/// One contact parameter over all points and both directions.
struct Span {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  void take(double value) { low = std::min(low, value), high = std::max(high, value); }
};

Span span_of(const std::string &key, const std::vector<ContactPoint> &points) {
  Span span;
  for (const auto &point : points) {
    if (key == "contact.gap") span.take(point.gap);
    if (key == "contact.normal_stiffness") span.take(point.kn);
    if (!has_friction(point.law)) continue;
    for (int direction = 0; direction < 2; ++direction) {
      if (key == "contact.tangential_stiffness") span.take(point.kt[direction]);
      if (key == "contact.friction") span.take(point.mu[direction]);
    }
  }
  return span;
}

std::string text_of(const Span &span) {
  if (span.low > span.high) return ""; // friction where no point has any
  return number_text(span.low) + (span.low == span.high ? "" : " .. " + number_text(span.high));
}

/// "cone", or "coulomb (3), bilateral (1)" with the numbers of points.
std::string laws_text(const std::vector<ContactPoint> &points) {
  std::map<Law, size_t> counts;
  for (const auto &point : points) ++counts[point.law];
  std::string result;
  for (const auto &[law, count] : counts) {
    result += (result.empty() ? "" : ", ") + std::string(word_of(law));
    if (counts.size() > 1) result += " (" + std::to_string(count) + ")";
  }
  return result;
}

std::string contact_origin(const Case &study, const std::string &key, const Span &span) {
  // A gap of zero in the model file looks the same here as none.
  if (key == "contact.gap" && span.low == 0 && span.high == 0)
    return study.model.empty() ? "default" : "model file or default";
  const auto &setting =
      key == "contact.normal_stiffness" ? study.contact.normal_stiffness : study.contact.tangential_stiffness;
  if (key != "contact.friction" && setting && setting->per_area) return "per area, below";
  return "model file";
}

std::vector<Row> rows_of(const Case &study, const std::vector<ContactPoint> &points, const Units &units) {
  std::vector<Row> rows;
  for (const auto &key : keys()) {
    Row row{key.name, "", units.instead_of(key.unit), "default"};
    if (key.text) {
      row.value = key.text(study);
    } else if (row.key == "contact.law") {
      row.value = laws_text(points);
    } else if (!points.empty()) {
      const Span span = span_of(key.name, points);
      row.value = text_of(span);
      row.origin = contact_origin(study, key.name, span);
    }
    if (row.value.empty()) continue;
    if (row.key == "continuation.omega" || row.key == "continuation.at" || row.key == "path.omega" ||
        row.key == "mode.near")
      row.unit = study.frequency_unit.name();
    if (study.path && (row.key == "path.range" || row.key == "path.at"))
      row.unit = units.instead_of(study.path->parameter->unit);
    if (const auto found = study.given.find(key.name); found != study.given.end())
      row.origin = found->second == "--out" ? "--out" : "given";
    rows.push_back(row);
    if (row.key == "continuation.omega") {
      const FrequencyUnit &unit = study.frequency_unit, other = unit.in_hertz(!unit.hertz);
      const auto in_other = [&](double omega) { return number_text(std::round(omega / other.radians() * 1e6) / 1e6); };
      rows.push_back(
          {"", "[" + in_other(study.omega_from) + ", " + in_other(study.omega_to) + "]", other.name(), row.origin});
    }
  }
  return rows;
}

} // namespace

void describe(std::ostream &out, const Case &study, const std::vector<ContactPoint> &points, const Units &units) {
  const auto rows = rows_of(study, points, units);
  size_t key_width = 0, value_width = 0;
  for (const auto &row : rows) {
    key_width = std::max(key_width, row.key.size());
    if (row.value.size() <= 40) value_width = std::max(value_width, row.value.size()); // long paths may stick out
  }
  for (const auto &row : rows)
    out << std::left << std::setw(static_cast<int>(key_width + 2)) << row.key
        << std::setw(static_cast<int>(value_width + 2)) << row.value << ' ' << std::setw(10)
        << (row.unit.empty() ? "" : "[" + row.unit + "]") << ' ' << row.origin << '\n';
}

} // namespace dovetail
