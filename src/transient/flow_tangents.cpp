// Derivatives of the motion, expanded along with it: each term of their series follows from the one before by the
// equations of motion, differentiated. Forces of contact are continuous at events; but for where sliders stand, and
// whither they begin to slip, nothing happens to the derivatives there.
#include <algorithm>
#include <cmath>

#include "contact/fourier.hpp"
#include "stuck/slab.hpp"
#include "transient/flow.hpp"
#include "transient/weighted_sum.hpp"

namespace dovetail {
namespace {

constexpr double tolerance = 1e-10; // of a step, of the largest derivative

} // namespace

Tangents Flow::tangents(int numbers) const {
  const int width = padded<double>(numbers + 1), n = modes_.count;
  Tangents out;
  out.numbers = numbers + 1;
  out.eta.reset(width, n), out.rate.reset(width, n);
  out.slider.reset(width, 2 * model_.points), out.along.reset(width, 2 * model_.points);
  return out;
}

// (3, padded numbers) of the displacements there, or with those of rates of the velocities.
std::vector<double> Flow::contact_tangents(const Dense &eta, int point) const {
  std::vector<double> out(3 * eta.rows);
  for (int i = 0; i < modes_.count; ++i)
    for (int d = 0; d < 3; ++d)
      add_scaled(eta.rows, modes_.contact[(i * model_.points + point) * 3 + d], eta.column(i), &out[d * eta.rows]);
  return out;
}

std::vector<double> Flow::acceleration(double t) const {
  std::vector<double> out(modes_.count);
  for (int k = series_order; k >= 2; --k)
    for (int i = 0; i < modes_.count; ++i) out[i] = out[i] * t + k * (k - 1) * term(k)[i];
  return out;
}

void Flow::begin(const State &state, const std::vector<Memory> &w, Tangents &tangents) {
  for (int point = 0; point < model_.points; ++point) {
    const std::array<double, 3> x = at_contact(state.eta.data(), point, touches_[point].origin());
    touches_[point].begin_tangents(state.touch[point], x, at_contact(state.rate.data(), point), w[point],
                                   contact_tangents(tangents.eta, point), contact_tangents(tangents.rate, point),
                                   tangents.slider.column(2 * point), tangents.along.column(2 * point));
  }
  tangents.largest = largest_of(static_cast<int>(tangents.eta.values.size()), tangents.eta.values.data());
}

// After expand: the terms of the motion are known.
void Flow::expand_tangents(const State &state, double time, const Tangents &tangents) {
  const int n = modes_.count, width = tangents.eta.rows, tall = static_cast<int>(pull_.size()), block = n * width,
            last = tangents.numbers - 1;
  const int closed = static_cast<int>(pulls_.size()) / tall;
  tangent_terms_.resize(static_cast<std::size_t>(series_order + 1) * block);
  const auto terms = [&](int k) { return &tangent_terms_[static_cast<std::size_t>(k) * block]; };
  std::copy_n(tangents.eta.values.begin(), block, terms(0));
  std::copy_n(tangents.rate.values.begin(), block, terms(1));
  std::vector<Series> slopes(modes_.loads.size(), Series{}); // of f(t) by omega, for the numbers' last
  for (std::size_t load = 0; load < slopes.size(); ++load)
    for (const int h : driven_[load]) {
      const double a = modes_.loads[load].fourier[cosine(h)], b = modes_.loads[load].fourier[sine(h)];
      const double w = h * omega_, c = std::cos(w * time), s = std::sin(w * time);
      double now = h * (b * c - a * s), quarter_on = -h * (a * c + b * s); // of df / d(h omega t), as in expand
      double before = 0;
      for (int k = 0; k <= series_order; ++k) {
        slopes[load][k] += tangents.turning * (time * now + before); // times t
        before = now;
        const double next = w / (k + 1) * quarter_on;
        quarter_on = -w / (k + 1) * now, now = next;
      }
    }
  std::vector<double> x(3 * width), g(static_cast<std::size_t>(closed) * width);
  for (int k = 0; k <= series_order; ++k) {
    for (int point = 0, c = 0; point < model_.points; ++point) {
      if (!closed_[point]) continue;
      for (int d = 0; d < 3; ++d)
        combine(n, width, &pulls_[static_cast<std::size_t>(c + d) * tall], terms(k), &x[d * width]);
      touches_[point].expand_tangents(state.touch[point], k, width, x.data(), tangents.slider.column(2 * point),
                                      tangents.along.column(2 * point), &g[static_cast<std::size_t>(c) * width]);
      c += 3;
    }
    if (k + 2 > series_order) continue; // the last terms: for cones that slip
    const double share = 1.0 / ((k + 1) * (k + 2));
    next_term({n, width, closed, tall, modes_.w2.data(), pulls_.data()}, share, model_.damping.stiffness * (k + 1),
              model_.damping.mass * (k + 1), terms(k), terms(k + 1), g.data(), terms(k + 2));
    for (std::size_t at = 0; at < modes_.viscous.size(); ++at)
      add_scaled(width, -share * (k + 1) * modes_.viscous[at], terms(k + 1) + at % n * width,
                 terms(k + 2) + at / n * width);
    for (std::size_t load = 0; load < slopes.size(); ++load)
      for (int i = 0; i < n; ++i)
        terms(k + 2)[i * width + last] += share * modes_.loads[load].vector[i] * slopes[load][k];
  }
}

double Flow::tangent_length(const Tangents &tangents) const {
  const int block = static_cast<int>(tangents.eta.values.size());
  double step = HUGE_VAL;
  for (const int k : {series_order - 1, series_order}) {
    const double most = largest_of(block, &tangent_terms_[static_cast<std::size_t>(k) * block]);
    if (most > 0) step = std::min(step, std::pow(tolerance * tangents.largest / most, 1.0 / k));
  }
  return step;
}

// state: after the step, and the event.
void Flow::advance_tangents(const State &state, double t, int touched, const TouchEvent &event, Tangents &tangents) {
  const int block = static_cast<int>(tangents.eta.values.size());
  const auto terms = [&](int k) { return &tangent_terms_[static_cast<std::size_t>(k) * block]; };
  double *eta = tangents.eta.values.data(), *rate = tangents.rate.values.data();
  std::copy_n(terms(series_order), block, eta);
  std::fill_n(rate, block, 0.0);
  for (int k = series_order - 1; k >= 0; --k) {
    scale_and_add(block, t, eta, rate);
    scale_and_add(block, t, terms(k), eta);
  }
  tangents.largest = std::max(tangents.largest, largest_of(block, eta));
  for (int point = 0; point < model_.points; ++point) {
    const bool here = point == touched;
    if (!here && !touches_[point].turns(state.touch[point])) continue;
    const std::array<double, 3> x = at_contact(state.eta.data(), point, touches_[point].origin());
    touches_[point].advance_tangents(state.touch[point], t, here ? event : TouchEvent{}, x,
                                     at_contact(state.rate.data(), point), contact_tangents(tangents.eta, point),
                                     tangents.slider.column(2 * point), tangents.along.column(2 * point));
  }
}

// The end of the period, at time t of its last step, comes the sooner the higher the frequency is.
void Flow::turn_end(const State &state, double t, Tangents &tangents) {
  const int last = tangents.numbers - 1;
  const double later = -2 * M_PI / (omega_ * omega_) * tangents.turning;
  const std::vector<double> a = acceleration(t);
  for (int i = 0; i < modes_.count; ++i) {
    tangents.eta(last, i) += later * state.rate[i];
    tangents.rate(last, i) += later * a[i];
  }
  for (int point = 0; point < model_.points; ++point)
    if (touches_[point].turns(state.touch[point])) {
      const std::array<double, 2> turn = touches_[point].turning(t);
      for (int d = 0; d < 2; ++d) tangents.along(last, 2 * point + d) += later * turn[d];
    }
}

Dense Flow::slider_tangents(const State &state, const Tangents &tangents) const {
  Dense out(tangents.eta.rows, 2 * model_.points);
  for (int point = 0; point < model_.points; ++point) {
    const std::array<double, 3> x = at_contact(state.eta.data(), point, touches_[point].origin());
    touches_[point].slider_tangents(state.touch[point], x, contact_tangents(tangents.eta, point),
                                    tangents.slider.column(2 * point), tangents.along.column(2 * point),
                                    out.column(2 * point));
  }
  return out;
}

} // namespace dovetail
