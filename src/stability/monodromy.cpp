#include "stability/monodromy.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "support/error.hpp"

namespace dovetail {
namespace {

// modes^T C modes
std::vector<double> between_modes(const std::vector<double> &C, const Dense &modes) {
  const int n = modes.rows;
  Dense whole(n, n), moved(n, n);
  whole.values = C;
  multiply(1, whole, modes, 0, moved);
  std::vector<double> out(C.size());
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      out[static_cast<std::size_t>(i) * n + j] =
          std::inner_product(modes.column(i), modes.column(i) + n, moved.column(j), 0.0);
  return out;
}

} // namespace

Monodromy::Monodromy(const DenseModel &model)
    : n_(model.dofs()), points_(model.points), damping_(model.damping), contact_(model.contact),
      shape_(model.dofs(), 3 * model.points) {
  if (!damping_.acts_in_time()) throw ComputeError("stability: not with hysteretic damping");
  Dense modes(n_, n_), mass(n_, n_);
  modes.values = model.K, mass.values = model.M;
  stiffness_ = symmetric_modes(modes, mass);
  if (stiffness_.size() != static_cast<std::size_t>(n_)) throw InputError(mass_not_positive(model.file));
  for (int c = 0; c < 3 * points_; ++c)
    for (int j = 0; j < n_; ++j) shape_(j, c) = modes(model.modes + c, j);
  if (!model.C.empty()) viscous_ = between_modes(model.C, modes);
  const double largest = std::max(std::abs(stiffness_.front()), std::abs(stiffness_.back()));
  while (rigid_ < n_ && std::abs(stiffness_[rigid_]) <= 1e-10 * largest) ++rigid_;
}

std::vector<std::complex<double>> Monodromy::multipliers(const ContactHistory &history, double omega) {
  follow(history, omega);
  find_indifferent(history);
  for (const std::vector<double> &q : indifferent_) // what they take from the others does not change those
    for (int c = 0; c < map_.columns; ++c) {
      double *column = map_.column(c);
      const double part = std::inner_product(q.begin(), q.end(), column, 0.0);
      for (int i = 0; i < map_.rows; ++i) column[i] -= part * q[i];
    }
  return eigenvalues(map_);
}

void Monodromy::set_held(const ContactHistory &history, int interval) {
  held_.clear();
  const Answer *answers = history.interval(interval);
  for (int s = 0; s < 2 * points_; ++s)
    if (answers[3 * (s / 2) + s % 2] == Answer::held) held_.push_back(s);
}

// rate = d/dtheta of [q; q' / speed; held v], where q'' = -(K q + C q' + contact) / Omega^2.
void Monodromy::assemble(const Answer *answers) {
  const int n = n_, held = static_cast<int>(held_.size());
  rate_.reset(2 * n + held, 2 * n + held);
  const double scale = 1 / (omega_ * omega_ * speed_);
  for (int j = 0; j < n; ++j) {
    rate_(j, n + j) = speed_;
    rate_(n + j, j) = -stiffness_[j] * scale;
    rate_(n + j, n + j) = -damping_.viscous(stiffness_[j], 1) / omega_;
  }
  for (std::size_t at = 0; at < viscous_.size(); ++at) rate_(n + at / n, n + at % n) -= viscous_[at] / omega_;
  const auto add = [&](int row, int column, double k) { // force k x_column on contact dof `row`
    const double *a = shape_.column(row), *b = shape_.column(column);
    for (int j = 0; j < n; ++j) {
      const double bj = scale * k * b[j];
      double *out = &rate_(n, j);
      for (int i = 0; i < n; ++i) out[i] -= a[i] * bj;
    }
  };
  for (int p = 0; p < points_; ++p) {
    const ContactPoint &point = contact_[p];
    const Answer *answer = answers + 3 * p;
    if (answer[2] == Answer::spring) add(3 * p + 2, 3 * p + 2, point.kn);
    for (int d = 0; d < 2; ++d) {
      if (answer[d] == Answer::spring || answer[d] == Answer::held) add(3 * p + d, 3 * p + d, point.kt[d]);
      if (answer[d] == Answer::forth) add(3 * p + d, 3 * p + 2, point.mu[d] * point.kn);
      if (answer[d] == Answer::back) add(3 * p + d, 3 * p + 2, -point.mu[d] * point.kn);
    }
  }
  for (int h = 0; h < held; ++h) { // T = k_t x - v
    const double *a = shape_.column(3 * (held_[h] / 2) + held_[h] % 2);
    for (int i = 0; i < n; ++i) rate_(n + i, 2 * n + h) = scale * a[i];
  }
}

// Sliders set at the beginning of the interval take their v from the motion there.
void Monodromy::apply_holds(const ContactHistory &history, int interval) {
  for (const ContactHistory::Hold &hold : history.holds) {
    if (hold.interval != interval) continue;
    const int point = hold.slider / 2;
    const double *t = shape_.column(3 * point + hold.slider % 2), *x = shape_.column(3 * point + 2);
    for (int c = 0; c < state_.columns; ++c) {
      const double *q = state_.column(c);
      double v = 0;
      for (int i = 0; i < n_; ++i) v += (hold.by_t * t[i] + hold.by_n * x[i]) * q[i];
      state_(2 * n_ + hold.slider, c) = v;
    }
  }
}

// The map, from the instant at which fewest sliders are held over from before.
void Monodromy::follow(const ContactHistory &history, double omega) {
  const int n = n_, intervals = history.intervals();
  omega_ = omega;
  double largest = std::abs(stiffness_.back());
  for (const ContactPoint &point : contact_) largest = std::max({largest, point.kn, point.kt[0], point.kt[1]});
  speed_ = std::max(1.0, std::sqrt(largest) / omega);
  int first = 0;
  for (int i = 0; i < intervals; ++i) {
    set_held(history, i);
    for (const ContactHistory::Hold &hold : history.holds)
      if (hold.interval == i) held_.erase(std::remove(held_.begin(), held_.end(), hold.slider), held_.end());
    if (i == 0 || held_.size() < sliders_.size()) first = i, sliders_ = held_;
  }
  const int size = 2 * n + static_cast<int>(sliders_.size());
  state_.reset(2 * n + 2 * points_, size);
  for (int i = 0; i < 2 * n; ++i) state_(i, i) = 1;
  for (int h = 2 * n; h < size; ++h) state_(2 * n + sliders_[h - 2 * n], h) = 1;
  for (int k = 0; k < intervals; ++k) {
    const int i = (first + k) % intervals;
    apply_holds(history, i);
    set_held(history, i);
    assemble(history.interval(i));
    const Dense &step = exponential_.of(rate_, history.ends[i + 1] - history.ends[i]);
    block_.reset(step.columns, size), moved_.reset(step.columns, size);
    for (int c = 0; c < size; ++c) {
      std::copy_n(state_.column(c), 2 * n, block_.column(c));
      for (std::size_t h = 0; h < held_.size(); ++h) block_(2 * n + h, c) = state_(2 * n + held_[h], c);
    }
    multiply(1, step, block_, 0, moved_);
    for (int c = 0; c < size; ++c) std::copy_n(moved_.column(c), 2 * n, state_.column(c));
  }
  map_.reset(size, size);
  for (int c = 0; c < size; ++c) {
    std::copy_n(state_.column(c), 2 * n, map_.column(c));
    for (int h = 2 * n; h < size; ++h) map_(h, c) = state_(2 * n + sliders_[h - 2 * n], c);
  }
}

// Rigid displacements of the structure, in its modes, that stretch no spring of a contact: of those closed at some time
// in the normal direction, of those stuck for ever in the tangential one. Sliders that are set anew go along; only a
// steady drift stretches these, too.
Dense Monodromy::unfelt(const ContactHistory &history, bool held_too) const {
  Dense stretch(rigid_, rigid_), unit(rigid_, rigid_);
  double largest = 0;
  for (const double entry : shape_.values) largest = std::max(largest, entry * entry);
  for (int c = 0; c < 3 * points_; ++c) {
    bool felt = false;
    for (int i = 0; i < history.intervals(); ++i) {
      const Answer answer = history.interval(i)[c];
      felt = felt || answer == Answer::spring || (held_too && answer == Answer::held);
    }
    const double *s = shape_.column(c);
    for (int j = 0; felt && j < rigid_; ++j)
      for (int i = 0; i < rigid_; ++i) stretch(i, j) += s[i] * s[j];
  }
  for (int i = 0; i < rigid_; ++i) unit(i, i) = 1;
  const std::vector<double> values = symmetric_modes(stretch, unit);
  int count = 0;
  while (count < rigid_ && values[count] < 1e-12 * largest) ++count;
  Dense out(rigid_, count);
  std::copy_n(stretch.values.begin(), out.values.size(), out.values.begin());
  return out;
}

void Monodromy::find_indifferent(const ContactHistory &history) {
  indifferent_.clear();
  if (rigid_ == 0) return;
  std::vector<std::vector<double>> states;
  const Dense places = unfelt(history, false), drifts = unfelt(history, true);
  for (int j = 0; j < places.columns; ++j) {
    std::vector<double> &state = states.emplace_back(map_.rows);
    std::copy_n(places.column(j), rigid_, state.begin());
    for (std::size_t h = 0; h < sliders_.size(); ++h) {
      const int point = sliders_[h] / 2, d = sliders_[h] % 2;
      state[2 * n_ + h] = contact_[point].kt[d] *
                          std::inner_product(state.begin(), state.begin() + rigid_, shape_.column(3 * point + d), 0.0);
    }
  }
  for (int j = 0; j < drifts.columns; ++j)
    std::copy_n(drifts.column(j), rigid_, states.emplace_back(map_.rows).begin() + n_);
  for (std::vector<double> &state : states) { // orthonormal, in this order: a drift changes places
    for (int pass = 0; pass < 2; ++pass)
      for (const std::vector<double> &q : indifferent_) {
        const double part = std::inner_product(q.begin(), q.end(), state.begin(), 0.0);
        for (std::size_t i = 0; i < q.size(); ++i) state[i] -= part * q[i];
      }
    const double length = std::sqrt(std::inner_product(state.begin(), state.end(), state.begin(), 0.0));
    for (double &entry : state) entry /= length;
    indifferent_.push_back(state);
  }
}

} // namespace dovetail
