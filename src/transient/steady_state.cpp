#include "transient/steady_state.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "contact/law_traits.hpp"
#include "transient/shooting.hpp"
#include "transient/start.hpp"

namespace dovetail {
namespace {

constexpr int watched = 32;         // instants of a period at which it is compared with the one before
constexpr double stable = 1 + 1e-4; // multipliers are known to that; weakly damped ones are just below 1
constexpr double kept_back = 0.1;   // of the work, for the last periods
constexpr int first_shot = 12; // periods before shooting is tried, from rest; later after twice as many each time, or
constexpr int short_wait = 40; // after so many more at most where the motion goes on changing by
constexpr double wild = 0.1;   // that
constexpr double unknown = std::numeric_limits<double>::infinity();

// What the changes to come add up to, from how they fell over the last periods.
double left_to_come(const std::vector<double> &changes) {
  constexpr int back = 4;
  const double last = changes.back();
  if (last < 1e-11) return last; // round-off
  if (changes.size() <= back) return unknown;
  const double ratio = std::pow(last / changes[changes.size() - 1 - back], 1.0 / back);
  return ratio < 1 ? last * ratio / (1 - ratio) : unknown;
}

// Instants of a period that show the harmonics wanted, and the fastest contact.
int enough_instants(const Flow &flow, int harmonics) {
  int instants = instants_for(harmonics);
  while (instants < std::min(8192.0, 8 * flow.contact_rate() / flow.omega())) instants *= 2;
  return instants;
}

bool opens(const DenseModel &model, const Motion &motion) {
  for (int p = 0; p < model.points; ++p) {
    const double play = model.standstill[p].x[2] - model.contact[p].gap;
    for (int j = 0; j < motion.instants && may_open(model.contact[p].law); ++j)
      if (motion.at(j)[model.modes + 3 * p + 2] + play < 0) return true;
  }
  return false;
}

// The march, and what is known of it.
class March {
public:
  March(const DenseModel &model, double omega, const std::vector<double> &start, const IntegrationSettings &settings)
      : March(model, omega, settings, start.empty()) {
    state_ = from_rest_ ? flow_.rest() : state_of(flow_, start);
  }
  March(const DenseModel &model, double omega, const MotionState &start, const IntegrationSettings &settings)
      : March(model, omega, settings, false) {
    state_ = flow_.state(start);
  }

  SteadyState to_the_end() {
    bool arrived = false;
    while (!arrived && alive_ && periods_left() > 0) {
      if (!march(watched) || changes_.empty()) continue;
      if (settles())
        arrived = confirm();
      else if (plain_ >= shoot_at_)
        arrived = shoot();
    }
    flow_.work += kept_back * settings_.work;
    if (!arrived && unstable_.found) arrived = go_on_from(unstable_);
    if (!arrived && alive_) arrived = confirm();
    return told(arrived);
  }

private:
  March(const DenseModel &model, double omega, const IntegrationSettings &settings, bool from_rest)
      : settings_(settings), flow_(model, omega), from_rest_(from_rest) {
    flow_.work = (1 - kept_back) * settings.work;
  }

  int periods_left() const { return settings_.periods - periods_ - 3; } // those of the end kept back

  bool march(int instants) {
    ++periods_, ++plain_;
    alive_ = flow_.period(state_, instants, now_);
    if (!alive_) return false;
    if (before_.instants > 0) {
      changes_.push_back(difference(now_, before_, flow_.model().modes));
      if (changes_.back() <= nearest_) nearest_ = changes_.back(), returned_ = state_;
    }
    std::swap(before_, now_);
    return true;
  }

  bool settles() const {
    return changes_.back() <= settings_.tolerance && (multiplier_ > 0 || left_to_come(changes_) <= settings_.tolerance);
  }

  // One period more, in detail: the one that is told.
  bool confirm() { return march(enough_instants(flow_, settings_.harmonics)) && !changes_.empty() && settles(); }

  void jump_to(const Flow::State &state) {
    state_ = state;
    before_ = {}, changes_.clear();
  }

  bool go_on_from(const Orbit &orbit) {
    jump_to(orbit.state);
    multiplier_ = orbit.multiplier;
    const bool arrived = march(watched) && confirm();
    if (!arrived) multiplier_ = 0;
    return arrived;
  }

  bool shoot() {
    // A motion that does not settle comes near to unstable periodic ones again and again.
    const bool roams = plain_ > first_shot && changes_.back() > wild;
    const Orbit orbit =
        periodic_orbit(flow_, roams ? returned_ : state_, 1e-3 * settings_.tolerance, periods_left() / 2, !from_rest_);
    periods_ += orbit.periods;
    shoot_at_ = plain_ + (roams ? std::min(plain_, short_wait) : plain_);
    nearest_ = unknown;
    if (!orbit.found && orbit.nearer < 0.3) { // sliders find their places by themselves, and then it may go on
      jump_to(orbit.state);
      shoot_at_ = plain_ + 4;
    }
    if (!orbit.found) return false;
    if (from_rest_ && orbit.multiplier > stable) {
      unstable_ = orbit;
      return false;
    }
    return go_on_from(orbit);
  }

  SteadyState told(bool arrived) const {
    SteadyState out;
    out.settled = arrived, out.periods = periods_, out.work = settings_.work - flow_.work, out.multiplier = multiplier_;
    out.change = changes_.empty() ? unknown : changes_.back();
    if (!alive_) return out;
    out.opens = opens(flow_.model(), before_);
    out.end = flow_.motion_state(state_);
    out.coefficients = coefficients_of(before_, settings_.harmonics);
    out.amplitude = amplitudes(before_, 2 * std::acos(-1) / flow_.omega() / before_.instants);
    return out;
  }

  IntegrationSettings settings_;
  Flow flow_;
  bool from_rest_, alive_ = true;
  int periods_ = 0, plain_ = 0; // all; of the march alone
  int shoot_at_ = from_rest_ ? first_shot : 3;
  double multiplier_ = 0; // of the motion that the march goes on from, if shooting found it
  Flow::State state_;
  Flow::State returned_;     // where it came nearest to the period before since the last shooting, and
  double nearest_ = unknown; // how near, as `change`
  Orbit unstable_;
  Motion now_, before_;         // before_: the last one
  std::vector<double> changes_; // from period to period
};

} // namespace

SteadyState steady_state(const DenseModel &model, double omega, const std::vector<double> &start,
                         const IntegrationSettings &settings) {
  return March(model, omega, start, settings).to_the_end();
}

SteadyState steady_state_from(const DenseModel &model, double omega, const MotionState &start,
                              const IntegrationSettings &settings) {
  return March(model, omega, start, settings).to_the_end();
}

} // namespace dovetail
