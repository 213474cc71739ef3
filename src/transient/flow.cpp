#include "transient/flow.hpp"

#include <algorithm>
#include <cmath>

#include "contact/fourier.hpp"
#include "contact/law_traits.hpp"
#include "stuck/slab.hpp"
#include "transient/weighted_sum.hpp"

namespace dovetail {
namespace {} // namespace

Flow::Flow(const DenseModel &model, double omega, double tolerance)
    : model_(model), modes_(free_modes(model)), tolerance_(tolerance) {
  const int n = modes_.count, m = 3 * model.points;
  set_omega(omega);
  eta_.resize(static_cast<std::size_t>(series_order + 1) * n), x_.resize(padded<double>(m)), g_.resize(m),
      now_.resize(2 * n);
  pull_.resize(padded<double>(n)), rest_pull_.resize(n);
  for (int i = 0; i < n; ++i)
    for (int c = 0; c < m; ++c) rest_pull_[i] += modes_.contact[i * m + c] * model.standstill[c / 3].force[c % 3];
  work_of_step_ = (series_order + 1) * (2.0 * n * m + 4.0 * n + 800.0 * model.points); // all points closed
  work_of_step_ += (series_order + 1) * static_cast<double>(modes_.viscous.size());
  for (const ContactPoint &point : model.contact)
    if (shares_slider(point.law)) work_of_step_ += 8.0 * series_order * series_order; // products of series
  for (const LoadCase &load : modes_.loads) {
    driven_.emplace_back(), courses_.emplace_back();
    for (int h = 1; sine(h) < static_cast<int>(load.fourier.size()); ++h)
      if (load.fourier[cosine(h)] != 0 || load.fourier[sine(h)] != 0) driven_.back().push_back(h);
  }
}

void Flow::set_omega(double omega) {
  const int n = modes_.count, m = 3 * model_.points;
  omega_ = omega;
  touches_.clear();
  for (int point = 0; point < model_.points; ++point) {
    std::array<double, 3> mobility{};
    for (int i = 0; i < n; ++i)
      for (int d = 0; d < 3; ++d) mobility[d] += std::pow(modes_.contact[i * m + 3 * point + d], 2);
    touches_.emplace_back(model_.contact[point], model_.standstill[point], mobility, 1 / omega);
  }
  size_ = reach_ = 0;
  std::vector<double> most(n, 0.0); // force at any time, at most
  for (const LoadCase &load : modes_.loads) {
    double sum = 0;
    for (const double a : load.fourier) sum += std::abs(a);
    for (int i = 0; i < n; ++i) most[i] += sum * std::abs(load.vector[i]);
  }
  for (int i = 0; i < n; ++i) size_ = std::max(size_, most[i] / std::max(modes_.w2[i], omega * omega));
}

double Flow::contact_rate() const {
  double rate = 0;
  for (const Touch &touch : touches_) rate = std::max(rate, touch.rate());
  return rate;
}

Flow::State Flow::modal_state(std::vector<double> eta, std::vector<double> rate, const std::vector<Memory> &w,
                              const std::vector<std::array<bool, 2>> &held) const {
  const int n = modes_.count, m = 3 * model_.points;
  State state{std::move(eta), std::move(rate), {}};
  std::vector<double> x(m), v(m);
  combine(n, m, state.eta.data(), modes_.contact.data(), x.data());
  combine(n, m, state.rate.data(), modes_.contact.data(), v.data());
  for (int point = 0; point < model_.points; ++point) {
    for (int d = 0; d < 3; ++d) x[3 * point + d] += touches_[point].origin()[d];
    state.touch.push_back(
        touches_[point].at(&x[3 * point], &v[3 * point], w[point], held.empty() ? std::array<bool, 2>{} : held[point]));
  }
  return state;
}

Flow::State Flow::state(const MotionState &at) const {
  const int n = modes_.count;
  std::vector<double> eta(n), rate(n);
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      eta[i] += modes_.momentum[i * n + j] * at.q[j], rate[i] += modes_.momentum[i * n + j] * at.v[j];
  return modal_state(std::move(eta), std::move(rate), at.w);
}

Flow::State Flow::rest() const {
  std::vector<Memory> w;
  for (const Standstill &at_rest : model_.standstill) w.push_back(at_rest.w);
  return modal_state(std::vector<double>(modes_.count), std::vector<double>(modes_.count), w);
}

MotionState Flow::motion_state(const State &state) const {
  const int n = modes_.count;
  MotionState out{std::vector<double>(n), std::vector<double>(n), sliders(state)};
  combine(n, n, state.eta.data(), modes_.shapes.data(), out.q.data());
  combine(n, n, state.rate.data(), modes_.shapes.data(), out.v.data());
  return out;
}

std::vector<Memory> Flow::sliders(const State &state) const {
  const int n = modes_.count, m = 3 * model_.points;
  std::vector<double> x(m);
  combine(n, m, state.eta.data(), modes_.contact.data(), x.data());
  std::vector<Memory> w;
  for (int point = 0; point < model_.points; ++point) {
    for (int d = 0; d < 3; ++d) x[3 * point + d] += touches_[point].origin()[d];
    w.push_back(touches_[point].sliders(state.touch[point], &x[3 * point]));
  }
  return w;
}

// seen_ and pulls_: an open point has no force, and of its motion only the normal part matters until it lands.
void Flow::lay_out(const State &state) {
  const auto same = [](bool closed, const TouchState &touch) { return closed == touch.closed; };
  if (std::equal(closed_.begin(), closed_.end(), state.touch.begin(), state.touch.end(), same)) return;
  closed_.clear();
  for (const TouchState &touch : state.touch) closed_.push_back(touch.closed);
  std::vector<int> columns;
  for (int c = 0; c < 3 * model_.points; ++c)
    if (closed_[c / 3] || c % 3 == 2) columns.push_back(c);
  const int n = modes_.count, m = 3 * model_.points, width = padded<double>(n);
  seen_columns_ = padded<double>(static_cast<int>(columns.size()));
  seen_.assign(static_cast<std::size_t>(n) * seen_columns_, 0), pulls_.clear();
  for (std::size_t j = 0; j < columns.size(); ++j) {
    for (int i = 0; i < n; ++i) seen_[i * seen_columns_ + j] = modes_.contact[i * m + columns[j]];
    if (!closed_[columns[j] / 3]) continue;
    for (int i = 0; i < n; ++i) pulls_.push_back(modes_.contact[i * m + columns[j]]);
    pulls_.resize(pulls_.size() + width - n);
  }
}

// Terms of the motion from time on, of the displacements and forces at the contact points along with them.
void Flow::expand(const State &state, double time) {
  const int n = modes_.count;
  lay_out(state);
  std::copy(state.eta.begin(), state.eta.end(), term(0));
  std::copy(state.rate.begin(), state.rate.end(), term(1));
  for (std::size_t load = 0; load < courses_.size(); ++load) {
    const std::vector<double> &fourier = modes_.loads[load].fourier;
    Series &force = courses_[load];
    force = {};
    force[0] = fourier.empty() ? 0 : fourier[0] / 2;
    for (const int h : driven_[load]) {
      const double a = fourier[cosine(h)], b = fourier[sine(h)];
      const double w = h * omega_, c = std::cos(w * time), s = std::sin(w * time);
      double now = a * c + b * s, quarter_on = b * c - a * s; // derivatives: in turn, with alternating signs
      for (int k = 0; k <= series_order; ++k) {
        force[k] += now;
        const double next = w / (k + 1) * quarter_on;
        quarter_on = -w / (k + 1) * now, now = next;
      }
    }
  }
  for (int k = 0; k <= series_order; ++k) {
    combine(n, seen_columns_, term(k), seen_.data(), x_.data());
    double *x = x_.data(), *g = g_.data();
    for (int point = 0; point < model_.points; ++point) {
      const bool closed = closed_[point];
      for (int d = closed ? 0 : 2; d < 3; ++d, ++x)
        if (k == 0) *x += touches_[point].origin()[d];
      if (closed)
        touches_[point].expand(state.touch[point], k, x - 3, g), g += 3;
      else
        touches_[point].expand_open(k, x[-1]);
    }
    if (k + 2 > series_order) continue;
    combine(static_cast<int>(g - g_.data()), static_cast<int>(pull_.size()), g_.data(), pulls_.data(), pull_.data());
    for (int i = 0; i < n && k == 0; ++i) pull_[i] -= rest_pull_[i];
    if (!modes_.viscous.empty()) {
      combine(n, n, term(k + 1), modes_.viscous.data(), now_.data());
      for (int i = 0; i < n; ++i) pull_[i] += (k + 1) * now_[i];
    }
    const double *now = term(k), *then = term(k + 1), share = 1.0 / ((k + 1) * (k + 2)),
                 by_stiffness = model_.damping.stiffness * (k + 1), by_mass = model_.damping.mass * (k + 1);
    double *out = term(k + 2);
    std::fill_n(out, n, -0.0); // see force_coefficient
    for (std::size_t load = 0; load < courses_.size(); ++load) {
      const double *vector = modes_.loads[load].vector.data(), course = courses_[load][k];
      for (int i = 0; i < n; ++i) out[i] += vector[i] * course;
    }
    for (int i = 0; i < n; ++i)
      out[i] = share * (out[i] - pull_[i] - modes_.w2[i] * (now[i] + by_stiffness * then[i]) - by_mass * then[i]);
  }
}

// Step after which the last two terms have grown to the tolerance.
double Flow::length(const State &state, double left) const {
  const double allowed = tolerance_ * size_;
  double step = left;
  for (const int k : {series_order - 1, series_order}) {
    double most = 0;
    for (int i = 0; i < modes_.count; ++i) most = std::max(most, std::abs(term(k)[i]));
    if (most != most) return most;
    if (most > 0) step = std::min(step, std::pow(allowed / most, 1.0 / k));
  }
  for (int point = 0; point < model_.points; ++point)
    step = std::min(step, touches_[point].longest(state.touch[point]));
  return step;
}

// Coordinates of the free modes at time t of the step, and d/dt.
void Flow::evaluate(double t, double *eta, double *rate) const {
  const int n = modes_.count;
  for (int i = 0; i < n; ++i) eta[i] = term(series_order)[i], rate[i] = series_order * term(series_order)[i];
  for (int k = series_order - 1; k >= 1; --k)
    for (int i = 0; i < n; ++i) eta[i] = eta[i] * t + term(k)[i], rate[i] = rate[i] * t + k * term(k)[i];
  for (int i = 0; i < n; ++i) eta[i] = eta[i] * t + term(0)[i];
}

// Displacement of the contact point, from there, or its velocity of rates.
std::array<double, 3> Flow::at_contact(const double *eta, int point, std::array<double, 3> from) const {
  const double *shape = &modes_.contact[3 * point];
  for (int i = 0; i < modes_.count; ++i, shape += 3 * model_.points)
    for (int d = 0; d < 3; ++d) from[d] += eta[i] * shape[d];
  return from;
}

void Flow::advance(State &state, double t, int touched, const TouchEvent &event) {
  evaluate(t, state.eta.data(), state.rate.data());
  for (int point = 0; point < model_.points; ++point) {
    const bool here = point == touched;
    std::array<double, 3> x{}, v{};
    if (here) {
      x = at_contact(state.eta.data(), point, touches_[point].origin());
      v = at_contact(state.rate.data(), point);
    }
    touches_[point].advance(state.touch[point], t, here ? event : TouchEvent{}, x, v);
  }
}

void Flow::record(double t, int instant, Motion &motion) {
  const int n = modes_.count;
  evaluate(t, now_.data(), now_.data() + n);
  combine(n, n, now_.data(), modes_.shapes.data(), &motion.q[static_cast<std::size_t>(instant) * n]);
  combine(n, n, now_.data() + n, modes_.shapes.data(), &motion.v[static_cast<std::size_t>(instant) * n]);
}

void Flow::note_size(const State &state) {
  const int n = modes_.count, m = 3 * model_.points;
  for (int i = 0; i < n; ++i)
    size_ =
        std::max({size_, std::abs(state.eta[i]), std::abs(state.rate[i]) / std::max(std::sqrt(modes_.w2[i]), omega_)});
  for (int point = 0; point < model_.points; ++point) {
    double reach = 0;
    for (int d = 0; d < 3; ++d) {
      double square = 0;
      for (int i = 0; i < n; ++i) square += std::pow(modes_.contact[i * m + 3 * point + d], 2);
      reach = std::max(reach, std::sqrt(square) * size_);
    }
    touches_[point].reach(reach);
    reach_ = std::max(reach_, reach);
  }
}

bool Flow::period(State &state, int instants, Motion &motion) {
  motion.instants = instants, motion.dofs = modes_.count;
  motion.q.resize(static_cast<std::size_t>(instants) * modes_.count), motion.v.resize(motion.q.size());
  return march(state, instants, &motion, nullptr);
}

bool Flow::period(State &state, Tangents &tangents) { return march(state, 0, nullptr, &tangents); }

bool Flow::march(State &state, int instants, Motion *motion, Tangents *tangents) {
  const double period = 2 * M_PI / omega_;
  double time = 0;
  int instant = 0;
  note_size(state);
  while (period - time > 1e-14 * period) {
    if ((work -= tangents ? work_of_step_ * (1 + tangents->numbers / 5.0) : work_of_step_) < 0) return false;
    ++steps_;
    expand(state, time);
    double step = length(state, period - time);
    if (tangents) {
      expand_tangents(state, time, *tangents);
      step = std::min(step, tangent_length(*tangents));
    }
    if (!(step > 0)) return false;
    Series powers;
    powers[0] = 1;
    for (int k = 1; k <= series_order; ++k) powers[k] = powers[k - 1] * step;
    TouchEvent first;
    int touched = -1;
    for (int point = 0; point < model_.points; ++point)
      if (const TouchEvent event = touches_[point].next(state.touch[point], powers, first.at); event.at < first.at)
        first = event, touched = point;
    if (touched >= 0) step *= first.at;
    for (; instant < instants && instant * period / instants < time + step; ++instant)
      record(instant * period / instants - time, instant, *motion);
    advance(state, step, touched, first);
    if (tangents) advance_tangents(state, step, touched, first, *tangents);
    for (const double eta : state.eta) {
      if (!std::isfinite(eta)) return false;
      size_ = std::max(size_, std::abs(eta));
    }
    time += step;
    if (tangents && !(period - time > 1e-14 * period)) turn_end(state, step, *tangents);
  }
  for (TouchState &touch : state.touch)
    for (int d = 0; d < 2; ++d)
      if (!touch.closed || touch.slides || touch.side[d] != 0) touch.moved[d] = HUGE_VAL; // still on its way
  return true;
}

} // namespace dovetail
