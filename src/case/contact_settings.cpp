#include "case/contact_settings.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "case/number_text.hpp"
#include "contact/law_traits.hpp"
#include "support/error.hpp"

namespace dovetail {
namespace {

struct LawWord {
  Law law;
  const char *word;
};
constexpr LawWord laws[] = {
    {Law::coulomb, "coulomb"}, {Law::cone, "cone"}, {Law::unilateral, "unilateral"}, {Law::bilateral, "bilateral"}};

/// The four parameters of the laws: everything below works through this table. The tangential ones are those of
/// friction.
struct Parameter {
  const char *name;
  std::optional<ContactSetting> ContactSettings::*setting;
  bool tangential;
  bool by_area; ///< may be given per area, under its name with _per_area
  const char *example;
  void (*store)(ContactPoint &point, double t1, double t2);
};

const Parameter parameters[] = {
    {"normal_stiffness", &ContactSettings::normal_stiffness, false, true, "1e9",
     [](ContactPoint &point, double value, double) { point.kn = value; }},
    {"tangential_stiffness", &ContactSettings::tangential_stiffness, true, true, "[1e6, 1e6]",
     [](ContactPoint &point, double t1, double t2) {
       point.kt = {t1, t2};
     }},
    {"friction", &ContactSettings::friction, true, false, "[0.3, 0.3]",
     [](ContactPoint &point, double t1, double t2) {
       point.mu = {t1, t2};
     }},
    {"gap", &ContactSettings::gap, false, false, "0.0",
     [](ContactPoint &point, double value, double) { point.gap = value; }},
};

std::string key_of(const Parameter &parameter) { return std::string("contact.") + parameter.name; }

// Of the case file or of a model.
void check_values(const ContactSetting &setting, const Parameter &parameter) {
  const Value &allowed = key_named(key_of(parameter))->value;
  for (size_t i = 0; i < setting.values.size(); ++i) {
    const double value = setting.values[i];
    const std::string fault = std::isfinite(value) ? allowed.fault(value) : "must be a finite number";
    if (fault.empty()) continue;
    const size_t width = setting.pairs ? 2 : 1;
    std::string which; // needed only where there are several
    if (setting.values.size() > width) which = " at contact point " + std::to_string(i / width) + " (counted from 0)";
    if (setting.pairs) which += i % 2 ? " along t2" : " along t1";
    throw InputError(setting.where + " = " + number_text(value) + which + ": " + fault);
  }
}

ContactSetting read_setting(const Entry &entry, const Parameter &parameter) {
  ContactSetting result;
  result.where = entry.where();
  if (!entry.is_list()) {
    result.values = {entry.finite()};
  } else {
    const auto items = entry.items();
    if (items.empty()) entry.refuse("is empty; write a number for all points, or one per contact point");
    const bool nested = items.front().is_list();
    // Two plain numbers are [t1, t2] for all points, also where there happen to be two points.
    result.pairs = parameter.tangential && (nested || items.size() == 2);
    result.per_point = nested || !result.pairs;
    for (const auto &item : items) {
      if (!nested || !parameter.tangential) {
        result.values.push_back(item.finite());
        continue;
      }
      const auto pair = item.items();
      for (const Entry &value : pair) result.values.push_back(value.finite());
      if (pair.size() != 2) item.refuse("must be a pair [t1, t2]");
    }
  }
  check_values(result, parameter);
  return result;
}

/// Values of (t1, t2), or twice the same, for each of n points.
std::vector<std::array<double, 2>> spread(const ContactSetting &setting, bool tangential, int n) {
  const size_t width = setting.pairs ? 2 : 1, count = setting.values.size() / width, points = static_cast<size_t>(n);
  if (setting.values.size() % width || (count != points && (count != 1 || setting.per_point)))
    throw InputError(setting.where + ": " + std::to_string(count) + (setting.pairs ? " pairs" : " values") +
                     " found, but there are N_x = " + std::to_string(n) + " contact points: write " +
                     (tangential ? "a number, one pair [t1, t2], or " : "one number, or ") + std::to_string(n) +
                     (setting.pairs ? " pairs" : " numbers"));
  std::vector<std::array<double, 2>> result(points);
  for (size_t i = 0; i < points; ++i) {
    const double *value = &setting.values[count == 1 ? 0 : i * width];
    result[i] = {value[0], value[width - 1]};
  }
  return result;
}

/// Makes stiffnesses of single points [N/m] of ones per area [N/m^3].
void times_area(std::vector<std::array<double, 2>> &values, const ContactSetting &setting,
                const std::vector<double> &area) {
  const auto unknown = std::find_if(area.begin(), area.end(), [](double value) { return !(value > 0); });
  if (area.size() != values.size() || unknown != area.end())
    throw InputError(setting.where + ": the area of " +
                     (area.size() == values.size()
                          ? "contact point " + std::to_string(unknown - area.begin()) + " (counted from 0)"
                          : std::string("the contact points")) +
                     " is not known: the model has no /contact/area for it, as models made of joints have; write the "
                     "stiffness of each point [N/m] instead");
  for (std::size_t i = 0; i < values.size(); ++i)
    for (double &value : values[i]) value *= area[i];
}

Law read_law(const Entry &entry) {
  const std::string found = entry.word();
  return std::find_if(std::begin(laws), std::end(laws), [&](const LawWord &each) { return each.word == found; })->law;
}

LawSetting read_laws(const Entry &entry) {
  LawSetting result{{}, entry.is_list(), entry.where()};
  if (!result.per_point) {
    result.values = {read_law(entry)};
    return result;
  }
  for (const Entry &item : entry.items()) result.values.push_back(read_law(item));
  if (result.values.empty()) entry.refuse("is empty; write one word for all points, or one per contact point");
  return result;
}

void spread_laws(const LawSetting &setting, std::vector<ContactPoint> &points) {
  const size_t found = setting.values.size(), wanted = points.size();
  if (setting.per_point && found != wanted)
    throw InputError(setting.where + ": " + std::to_string(found) +
                     " words found, but there are N_x = " + std::to_string(wanted) +
                     " contact points: write one word without brackets, or " + std::to_string(wanted) + " words");
  for (size_t i = 0; i < wanted; ++i) points[i].law = setting.values[setting.per_point ? i : 0];
}

/// The cone has one coefficient of friction. Then what the law of a point does not know is cleared.
void check_friction(std::vector<ContactPoint> &points, const std::string &where) {
  for (size_t i = 0; i < points.size(); ++i) {
    ContactPoint &point = points[i];
    if (shares_slider(point.law) && point.mu[0] != point.mu[1])
      throw InputError(where + " = [" + number_text(point.mu[0]) + ", " + number_text(point.mu[1]) +
                       "] at contact point " + std::to_string(i) +
                       " (counted from 0): contact.law = \"cone\" knows one coefficient for all directions of the "
                       "plane; write the same number for t1 and t2, or contact.law = \"coulomb\"");
    if (!has_friction(point.law)) point.kt = point.mu = {0, 0};
  }
}

} // namespace

const char *word_of(Law law) {
  return std::find_if(std::begin(laws), std::end(laws), [&](const LawWord &each) { return each.law == law; })->word;
}

std::vector<std::string> law_words() {
  std::vector<std::string> words;
  for (const LawWord &each : laws) words.push_back(each.word);
  return words;
}

ContactSettings read_contact_settings(const Document &document) {
  ContactSettings result;
  if (const Entry law = document["contact.law"]) result.law = read_laws(law);
  for (const auto &parameter : parameters) {
    const std::string name = key_of(parameter);
    const Entry single = document[name],
                by_area = parameter.by_area ? document[name + "_per_area"] : Entry("", name, nullptr);
    if (single && by_area) by_area.refuse("and " + name + " both say the same; keep one");
    const Entry &entry = by_area ? by_area : single;
    if (!entry) continue;
    if (parameter.tangential && !result.law.any(has_friction))
      entry.refuse("has no effect, because no contact point has friction; delete this key, or write contact.law = "
                   "\"coulomb\"");
    result.*parameter.setting = read_setting(entry, parameter);
    (result.*parameter.setting)->per_area = bool(by_area);
  }
  return result;
}

std::vector<ContactPoint> contact_points(const ContactSettings &from_case, const ContactSettings &from_model, int n) {
  std::vector<ContactPoint> points(static_cast<size_t>(n));
  spread_laws(from_case.law, points);
  const bool friction = from_case.law.any(has_friction);
  for (const auto &parameter : parameters) {
    if (parameter.tangential && !friction) continue;
    const auto &in_case = from_case.*parameter.setting, &in_model = from_model.*parameter.setting;
    const auto &setting = in_case ? in_case : in_model;
    if (!setting) {
      if (parameter.setting == &ContactSettings::gap) continue; // 0 where nobody says otherwise
      throw InputError(from_case.file + ": contact." + parameter.name +
                       " is missing, and the model file has no /contact/" + parameter.name + ": write " +
                       parameter.name + " = " + parameter.example + " under [contact]");
    }
    check_values(*setting, parameter);
    auto values = spread(*setting, parameter.tangential, n);
    if (setting->per_area) times_area(values, *setting, from_model.area);
    for (size_t i = 0; i < points.size(); ++i) parameter.store(points[i], values[i][0], values[i][1]);
  }
  const auto &friction_setting = from_case.friction ? from_case.friction : from_model.friction;
  check_friction(points, friction_setting ? friction_setting->where : "");
  return points;
}

std::vector<double> initial_preload(const Case &study, int n) {
  const size_t wanted = 3 * static_cast<size_t>(n), found = study.preload_initial.size();
  if (found == 1) return std::vector<double>(wanted, study.preload_initial.front());
  if (found != wanted)
    throw InputError(study.preload_initial_where + ": " + std::to_string(found) +
                     " values found, but there are N_x = " + std::to_string(n) +
                     " contact points: write one number, or 3 per contact point (t1, t2, n), " +
                     std::to_string(wanted) + " in all");
  return study.preload_initial;
}

} // namespace dovetail
