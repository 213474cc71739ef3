#include "transient/orbit_curve.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace dovetail {
namespace {

constexpr double first_step = 1e-3, shortest = 1e-7;
constexpr double longest_omega = 0.01;   // of the unit
constexpr double longest_motion = 0.25;  // of the motion at hand
constexpr double smallest_motion = 1e-3; // that counts
constexpr double converged = 1e-7;       // correction: what is left is ten times less;
constexpr double precisely = 1e-9;       // between points;
constexpr double hopeless = 10;          // one as long as that
constexpr double slow = 0.3;             // by which corrections shall fall with the same derivative
constexpr int most_newton = 14, most_anew = 4, enough_newton = 8; // iterations; derivatives
constexpr int quick = 4, laborious = 6;
constexpr double most_turned = 0.64, smooth = 0.2, bent = 0.4; // angles [rad]
constexpr double most_correction = 1;                          // of the step
constexpr double most_astray = 0.1; // by which a step may point away from the tangent more than the curve turns [rad]
constexpr double most_off = 0.05;   // of a step, by which its middle may lie off the curve
constexpr double growth = 1.6, shrinkage = 0.7;
constexpr double same_leg = -0.99;   // cosine of the angle beyond which a leg is that which led here
constexpr double corner_step = 2e-3; // shorter steps that fail may be at a corner, or go round it
constexpr double corner_again = 16;
constexpr double most_work = 2e9; // multiplications, for one period: an orderly one takes 1e5 to 1e7
constexpr long no_limit = 1L << 62;

Numbers ahead(const Numbers &z, double step, const Numbers &t) {
  Numbers out = z;
  add(out, step, t);
  return out;
}

} // namespace

OrbitCurve::OrbitCurve(DenseModel model, double omega, double omega_unit, double longest_step)
    : model_(std::move(model)), flow_(model_, omega), map_(flow_, no_limit), omega_begun_(omega), unit_(omega_unit),
      longest_(longest_step) {}

Numbers OrbitCurve::motion_numbers(const Numbers &z) const {
  Numbers y(z.begin(), z.end() - 1);
  for (double &number : y) number *= scale_;
  return y;
}

double OrbitCurve::size(const Numbers &z) const { return norm({z.begin(), z.begin() + map_.motion_numbers()}); }

void OrbitCurve::set_out(const Numbers &z) { flow_.set_omega(z.back() * unit_), flow_.work = most_work; }

// By how much a period misses the motion it began with; freely: no slider held, and which of them hardly move.
bool OrbitCurve::miss(const Numbers &z, bool freely, Numbers &r, Held &still) {
  if (!(z.back() > 0)) return false;
  set_out(z);
  const Numbers y = motion_numbers(z);
  if (!(freely ? map_.next(y, r, still) : map_.next_held(y, r, held_))) return false;
  for (std::size_t i = 0; i < r.size(); ++i) r[i] = (r[i] - y[i]) / scale_;
  return true;
}

void OrbitCurve::take(const Place &place) { derivative_ = place.derivative, held_ = place.held; }

// derivative_ at z, and held_.
bool OrbitCurve::linearise(const Numbers &z) {
  const int N = static_cast<int>(map_.size());
  Numbers next;
  if (!miss(z, true, next, held_)) return false;
  set_out(z);
  if (!map_.next_with_derivative(motion_numbers(z), held_, unit_ / scale_, next, derivative_)) return false;
  for (int j = 0; j < N; ++j)
    for (int i = 0; i < N; ++i)
      if (map_.is_held(i, held_) || map_.is_held(j, held_)) derivative_(i, j) = 0;
  for (int i = 0; i < N; ++i) {
    derivative_(i, i) -= 1; // held: as of one that slips, whose place does not depend on where it was: the sign stays
    if (map_.is_held(i, held_)) derivative_(i, N) = 0;
  }
  return true;
}

void OrbitCurve::border(const Numbers &row, Factors &out) {
  const int N = derivative_.rows;
  Dense whole(N + 1, N + 1);
  for (int j = 0; j <= N; ++j) {
    std::copy_n(derivative_.column(j), N, whole.column(j));
    whole(N, j) = row[j];
  }
  out.factor(whole);
}

Numbers OrbitCurve::tangent(const Factors &factors) const {
  Numbers t(derivative_.columns);
  t.back() = 1;
  factors.solve(t.data());
  const double length = norm(t);
  for (double &number : t) number /= length;
  return t;
}

// Newton's method on the plane through z across `row`, with the same derivative as long as that does. Sliders that
// hardly move go where the period leaves them.
bool OrbitCurve::correct(Numbers &z, const Numbers &row, Factors factors, double tolerance) {
  const Numbers guess = z;
  double before = HUGE_VAL;
  for (int i = 0, anew = 0; i < most_newton; ++i) {
    Numbers r;
    Held still;
    ++newton_;
    if (!miss(z, true, r, still)) return false;
    Numbers drift(r.size()), correction(z.size());
    for (std::size_t j = 0; j < r.size(); ++j) (map_.is_held(j, held_) ? drift[j] : correction[j]) = r[j];
    for (double &number : correction) number = -number;
    correction.back() = dot(row, guess) - dot(row, z);
    factors.solve(correction.data());
    const double length = norm(correction) + norm(drift);
    if (!(length < hopeless)) return false;
    add(z, 1, correction);
    for (std::size_t j = 0; j < drift.size(); ++j) z[j] += drift[j];
    const bool same = still == held_;
    if (length < tolerance * std::max(1.0, size(z)) && (same || i > enough_newton)) return true;
    if (length > slow * before || !same) {
      if (++anew > most_anew || !linearise(z)) return false;
      border(row, factors);
    }
    before = length;
  }
  return false;
}

bool OrbitCurve::begin(const MotionState &nearby, int direction) {
  Numbers z = map_.numbers(flow_.state(nearby));
  scale_ = map_.motion_size(z);
  if (!(scale_ > 0)) return false;
  for (double &number : z) number /= scale_;
  z.push_back(omega_begun_ / unit_);
  Numbers row(z.size());
  row.back() = direction;
  newton_ = 0;
  Factors factors;
  if (!linearise(z)) return false;
  border(row, factors);
  if (!correct(z, row, factors, converged) || !linearise(z)) return false;
  border(row, factors);
  stand(z, tangent(factors));
  step_ = first_step;
  limit_step();
  return std::isfinite(norm(here_->t));
}

// With the derivative as linearised last, which is that of z.
void OrbitCurve::stand(Numbers z, Numbers t) {
  border(t, factors_);
  sign_ = factors_.sign();
  before_ = here_;
  here_ = std::make_shared<Place>(Place{std::move(z), std::move(t), derivative_, held_});
  came_ = before_ ? ahead(here_->z, -1, before_->z) : here_->t;
  const double length = norm(came_);
  for (double &number : came_) number /= length;
}

// trial_ by a step along t, with that derivative, if the sense is kept, or if the curve runs smoothly to there, too.
bool OrbitCurve::arrive(const Numbers &t, double step, const Factors &factors, Checks checks) {
  const Numbers guess = ahead(here_->z, step, t);
  trial_ = guess;
  if (!correct(trial_, t, factors, converged) || !linearise(trial_)) return false;
  Factors there;
  border(t, there);
  trial_tangent_ = tangent(there);
  turned_ = std::acos(std::clamp(dot(trial_tangent_, t), -1.0, 1.0));
  const double aside = norm(ahead(trial_, -1, guess)) / step;
  if (!(turned_ < most_turned && aside < most_correction)) return false;
  if (checks == Checks::none) return true;
  if (there.sign() != sign_) return false; // it leads on along the curve backwards
  return checks == Checks::sense || (std::atan(aside) < turned_ + most_astray && hangs_together(there));
}

// Whether the middle of the cubic from here to trial_ lies on the curve, by one correction: else the step led to
// another piece of it, or across a loop.
bool OrbitCurve::hangs_together(const Factors &there) {
  const Numbers way = ahead(trial_, -1, here_->z);
  const double length = norm(way);
  Numbers middle = ahead(here_->z, 0.5, way), r;
  add(middle, length / 8, here_->t), add(middle, -length / 8, trial_tangent_);
  Held none;
  if (!miss(middle, false, r, none)) return false;
  r.push_back(0);
  for (std::size_t i = 0; i + 1 < r.size(); ++i)
    if (map_.is_held(i, held_)) r[i] = 0;
  there.solve(r.data());
  return norm(r) < most_off * length;
}

// On the leg that led here. In a corner the tangent may be that of another one.
bool OrbitCurve::behind(const Numbers &z) const {
  const Numbers way = ahead(z, -1, here_->z);
  return std::min(dot(way, here_->t), dot(way, came_)) < same_leg * norm(way);
}

// The tangent of the leg beyond a corner by the derivative there, and its sense by the determinant; where that leads
// nowhere, the other sense.
bool OrbitCurve::round_corner(double step) {
  for (const double beyond : {1.0, 0.1, 10.0}) {
    if (!linearise(ahead(here_->z, beyond * step, here_->t))) continue;
    Factors factors;
    border(here_->t, factors);
    Numbers t = tangent(factors); // with it as border the sign is the same
    const Dense derivative = derivative_;
    const Held held = held_;
    if (factors.sign() != sign_)
      for (double &number : t) number = -number;
    for (int sense = 0; sense < 2; ++sense) {
      derivative_ = derivative, held_ = held;
      border(t, factors);
      if (arrive(t, step, factors, Checks::none) && dot(trial_tangent_, here_->t) > same_leg && !behind(trial_))
        return true;
      for (double &number : t) number = -number;
    }
  }
  return false;
}

bool OrbitCurve::step() {
  newton_ = 0;
  double corner_due = corner_step;
  for (double step = step_; step >= shortest; step /= 2) {
    const int before = newton_;
    held_ = here_->held;
    const bool smoothly = arrive(here_->t, step, factors_, step > corner_step ? Checks::all : Checks::sense);
    if (!smoothly) {
      if (step > corner_due) continue;
      corner_due = step / corner_again; // each time it takes as long as several steps
      if (!round_corner(step)) continue;
    }
    const int took = newton_ - before;
    stand(trial_, trial_tangent_);
    corner_ = !smoothly;
    largest_ = std::max(largest_, size(here_->z));
    step_ = step;
    if (smoothly && took <= quick && turned_ < smooth) step_ *= growth;
    if (took > laborious || turned_ > bent) step_ *= shrinkage;
    limit_step();
    return true;
  }
  return false;
}

void OrbitCurve::limit_step() {
  step_ = std::min({step_, longest_ * largest_, longest_motion * std::max(size(here_->z), smallest_motion),
                    longest_omega / std::max(std::abs(here_->t.back()), longest_omega)});
  step_ = std::max(step_, 10 * shortest);
}

double OrbitCurve::way() const { return norm(ahead(here_->z, -1, before_->z)); }

double OrbitCurve::along(const Place &place) const {
  return dot(ahead(place.z, -1, before_->z), ahead(here_->z, -1, before_->z)) / way();
}

// Through both ends of the last step with the tangents there.
Numbers OrbitCurve::cubic(double part) const {
  const double left = 1 - part, length = way();
  Numbers z(here_->z.size());
  add(z, left * left * (1 + 2 * part), before_->z), add(z, part * part * (3 - 2 * part), here_->z);
  add(z, length * left * left * part, before_->t), add(z, -length * part * part * left, here_->t);
  return z;
}

OrbitCurve::PlacePtr OrbitCurve::between(double along) {
  const double length = way();
  Numbers row = ahead(here_->z, -1, before_->z);
  for (double &number : row) number /= length;
  Numbers guess = cubic(along / length);
  add(guess, along - dot(row, ahead(guess, -1, before_->z)), row);
  take(*here_);
  return find(std::move(guess), row, precisely);
}

OrbitCurve::PlacePtr OrbitCurve::at(double omega, Numbers guess, bool rises) {
  guess.back() = omega / unit_;
  Numbers row(guess.size());
  row.back() = rises ? 1 : -1;
  newton_ = 0;
  return linearise(guess) ? find(std::move(guess), row, converged) : nullptr;
}

// The motion on the plane through z across `row`, with the derivative at hand to begin with.
OrbitCurve::PlacePtr OrbitCurve::find(Numbers z, const Numbers &row, double tolerance) {
  newton_ = 0;
  Factors factors;
  border(row, factors);
  if (!correct(z, row, factors, tolerance) || !linearise(z)) return nullptr;
  border(row, factors);
  Numbers t = tangent(factors);
  return std::make_shared<Place>(Place{std::move(z), std::move(t), derivative_, held_});
}

OrbitCurve::PlacePtr OrbitCurve::corner() {
  newton_ = 0;
  const Numbers chord = ahead(here_->z, -1, before_->z);
  const double c = dot(before_->t, here_->t), step = (dot(chord, before_->t) - c * dot(chord, here_->t)) / (1 - c * c);
  if (!(step > 0 && step < 2 * norm(chord))) return nullptr;
  const Numbers guess = ahead(before_->z, step, before_->t);
  Place out{guess, before_->t, {}, {}};
  take(*before_);
  Factors factors;
  border(out.t, factors);
  if (!correct(out.z, out.t, factors, converged) || norm(ahead(out.z, -1, guess)) > most_correction * step)
    return nullptr;
  return std::make_shared<Place>(std::move(out));
}

MotionState OrbitCurve::motion_state(const Place &place) const {
  return flow_.motion_state(map_.state(motion_numbers(place.z), {}));
}

Motion OrbitCurve::motion(const Place &place, int instants, double aside) {
  const Numbers z = ahead(place.z, aside, place.t);
  set_out(z);
  Flow::State at = map_.state(motion_numbers(z), {});
  Motion motion;
  flow_.period(at, instants, motion); // that period, or one close to it, was integrated before
  return motion;
}

std::vector<std::complex<double>> OrbitCurve::multipliers(const Place &place) {
  if (place.derivative.rows > 0)
    take(place);
  else if (!linearise(place.z))
    return {};
  Dense map(derivative_.rows, derivative_.rows);
  for (int j = 0; j < map.rows; ++j) {
    if (map_.is_held(j, held_)) continue;
    std::copy_n(derivative_.column(j), map.rows, map.column(j));
    map(j, j) += 1;
  }
  return eigenvalues(map);
}

// omega_begun_ makes the weights of the numbers: given again to the constructor. The unit may be another one there, for
// the end of the sweep may move.
void OrbitCurve::save(Archive &archive) const {
  for (const auto &[name, value] : {std::pair{"begun_at", omega_begun_},
                                    {"unit", unit_},
                                    {"scale", scale_},
                                    {"step", step_},
                                    {"largest", largest_}})
    archive.note(name, value);
  for (const auto &[name, numbers] : {std::pair{"z", &here_->z}, {"t", &here_->t}, {"came", &came_}})
    archive.note(name, *numbers);
}

bool OrbitCurve::restore(Archive &archive) {
  Numbers z, t;
  archive.field("unit", unit_);
  archive.field("scale", scale_);
  archive.field("step", step_);
  archive.field("largest", largest_);
  archive.field("z", z);
  archive.field("t", t);
  archive.field("came", came_);
  const std::size_t size = map_.size() + 1;
  if (z.size() != size || t.size() != size || came_.size() != size || !linearise(z)) return false;
  const Numbers came = came_;
  stand(std::move(z), std::move(t));
  came_ = came;
  return true;
}

} // namespace dovetail
