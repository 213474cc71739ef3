#include "results/point_record.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "harmonic/gathering.hpp"

namespace dovetail {
namespace {

constexpr int per_contact = 5; // numbers of a contact point

// Energies come in scaled units, force times displacement (docs/theory/equations.md, section 7), and leave in the
// user's.
std::vector<double> numbers_of(const Scales &scales, const std::vector<Activity> &activity) {
  const double energy = std::pow(scales.modal * scales.frequency, 2);
  std::vector<double> own;
  for (const Activity &did : activity)
    own.insert(own.end(), {did.stick(), did.slip, did.open, energy * did.dissipation, double(did.events)});
  return own;
}

ContactRecord contact_of(const std::vector<double> &all) {
  ContactRecord record;
  for (std::size_t i = 0; i < all.size(); i += per_contact) {
    record.stick.push_back(all[i]);
    record.slip.push_back(all[i + 1]);
    record.open.push_back(all[i + 2]);
    record.dissipation.push_back(all[i + 3]);
    record.events.push_back(static_cast<int>(all[i + 4]));
  }
  return record;
}

// (N_a + 3 N_x, 2H+1) coefficients in user units, and what is behind them; nothing where there is nothing.
std::pair<std::vector<double>, double> physical(const Layout &layout, const Scales &scales,
                                                std::vector<double> coefficients) {
  if (coefficients.empty()) return {};
  const double last = coefficients.back();
  coefficients.pop_back();
  for (std::size_t i = 0; i < coefficients.size(); ++i)
    coefficients[i] *= i < static_cast<std::size_t>(layout.modes) * layout.width ? scales.modal : scales.contact;
  return {std::move(coefficients), last};
}

} // namespace

const std::vector<const char *> &event_names() {
  static const std::vector<const char *> names = {"fold",   "peak",      "branch", "stability",   "start",  "cut",
                                                  "corner", "harmonics", "leap",   "integration", "missed", "outside"};
  return names;
}

std::string name_of_unknown(int unknown, PetscInt modes, const std::string &watch) {
  if (unknown < 0) return watch;
  const long contact = unknown - static_cast<long>(modes);
  if (contact < 0) return "a" + std::to_string(unknown + 1);
  return "x" + std::to_string(contact / 3 + 1) + (contact % 3 == 0 ? ".t1" : contact % 3 == 1 ? ".t2" : ".n");
}

void CurveEnds::add(const End &point) {
  if (!first_known_) first_.push_back(point);
  first_known_ = first_known_ || first_.size() == 2;
  last_.push_back(point);
  if (last_.size() > 2) last_.erase(last_.begin());
}

const CurveEnds::End *CurveEnds::falling() const {
  return first_.size() == 2 && first_[0].amplitude > first_[1].amplitude ? &first_[0] : nullptr;
}

const CurveEnds::End *CurveEnds::rising() const {
  return last_.size() == 2 && last_[1].amplitude > last_[0].amplitude ? &last_[1] : nullptr;
}

PointRecord collect(const BranchPoint &point, double seconds, double scale) {
  const HarmonicSystem &system = point.system;
  const Layout &layout = system.layout();
  PointRecord record;
  record.omega = system.parameter().at(point.parameter).omega * system.scales().frequency;
  record.arclength = point.arclength;
  record.harmonics = system.harmonics();
  record.located = point.located;
  record.newton = point.newton.newton, record.linear = point.newton.linear;
  record.residual = point.newton.residual;
  record.seconds = seconds;
  record.progress = point.progress;
  if (point.stability) {
    record.stable = static_cast<int>(point.stability->verdict);
    record.instability = static_cast<int>(point.stability->kind);
    record.multiplier = point.stability->multiplier;
  }
  if (const ErrorEstimate *error = point.error)
    record.harmonics_error = error->harmonics, record.sampling_error = error->sampling,
    record.modes_error = error->modes;
  record.between_error = point.between;
  Gathering all(layout);
  all.add_points(numbers_of(system.scales(), point.activity), per_contact);
  all.add(point.y);
  if (point.tangent) all.add(point.tangent);
  all.bring();
  record.contact = contact_of(all.take(0));
  for (std::size_t p = 0; p < record.contact.open.size(); ++p)
    ++(record.contact.open[p] > 0 ? record.open : record.contact.slip[p] > 0 ? record.slip : record.stick);
  for (double *share : {&record.stick, &record.slip, &record.open}) *share /= std::max<double>(1, layout.points);
  record.coefficients = physical(layout, system.scales(), all.take(1)).first;
  if (!point.tangent) return record;
  const double length = plain_length(point.tangent);
  std::tie(record.tangent, record.tangent_parameter) = physical(layout, system.scales(), all.take(2));
  for (double &value : record.tangent) value /= length;
  record.tangent_parameter *= scale / length;
  record.tangent_omega = point.omega_slope * system.scales().frequency / length;
  return record;
}

} // namespace dovetail
