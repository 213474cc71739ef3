#include "contact/exact_law.hpp"

#include <algorithm>
#include <cmath>

#include "contact/fourier.hpp"
#include "contact/wide.hpp"

namespace dovetail {
namespace {

constexpr double period = 2 * M_PI;
constexpr int most_events = 16; // lift-offs and landings in one cell; more are round-off

// mask += weight / (2 pi) * integral of exp(i m theta) between two instants
DOVETAIL_WIDE void integrate(int count, const double *inverse, const double *c0, const double *s0, const double *c1,
                             const double *s1, double weight, double *__restrict cosine, double *__restrict sine) {
  for (int m = 0; m < count; ++m) {
    const double scale = weight * inverse[m];
    cosine[m] += scale * (s1[m] - s0[m]);
    sine[m] += scale * (c0[m] - c1[m]);
  }
}

// share += coefficients of the indicator of the same stretch, its mean left out
DOVETAIL_WIDE void add_share(int harmonics, const double *inverse, const double *c0, const double *s0, const double *c1,
                             const double *s1, double *__restrict share) {
  for (int k = 1; k <= harmonics; ++k) {
    share[cosine(k)] += 2 * inverse[k] * (s1[k] - s0[k]);
    share[sine(k)] += 2 * inverse[k] * (c0[k] - c1[k]);
  }
}

// t = by_t * E, n = by_n * E, where E is the row of the synthesis at an instant
DOVETAIL_WIDE void scale_rows(int harmonics, const double *c, const double *s, double by_t, double by_n,
                              double *__restrict t, double *__restrict n) {
  t[0] = by_t / 2, n[0] = by_n / 2;
  for (int k = 1; k <= harmonics; ++k) {
    t[cosine(k)] = by_t * c[k], t[sine(k)] = by_t * s[k];
    n[cosine(k)] = by_n * c[k], n[sine(k)] = by_n * s[k];
  }
}

// A round from some instant to the same one of the next period, put in the order of one from 0 to 2 pi.
void begin_at_zero(std::vector<Stretch> &run) {
  if (run.size() > 1 && run.back().end - run.back().begin < 1e-12) { // what ends at the last instant, found once more
    run[run.size() - 2].end = run.back().end, run[run.size() - 2].to = run.back().to;
    run.pop_back();
  }
  auto later = std::find_if(run.begin(), run.end(), [](const Stretch &s) { return s.end > period; });
  if (later == run.end()) return;
  if (later->begin < period) {
    Stretch rest = *later;
    rest.begin = period, rest.from = 0;
    later->end = period, later->to = 0;
    later = run.insert(later + 1, rest);
  }
  for (auto s = later; s != run.end(); ++s) s->begin -= period, s->end -= period;
  std::rotate(run.begin(), later, run.end());
}

} // namespace

ExactLaw::ExactLaw(int harmonics)
    : harmonics_(harmonics), grid_(harmonics),
      instants_(grid_, coefficient_count(harmonics)), sliders_{Slider(harmonics, grid_, instants_),
                                                               Slider(harmonics, grid_, instants_)},
      approach_(harmonics), p_(coefficient_count(harmonics)), values_(3 * grid_.ends), slopes_(values_.size()),
      inverse_(coefficient_count(harmonics)), share_(inverse_.size()) {
  for (int m = 1; m < coefficient_count(harmonics); ++m) inverse_[m] = 1 / (period * m);
}

void ExactLaw::evaluate(const ContactPoint &point, const Standstill &standstill, const double *X, double *G,
                        Activity &activity, Linearisation &linear) {
  const int n = coefficient_count(harmonics_), ends = grid_.ends;
  std::fill_n(G, 3 * n, 0.0);
  activity = {};
  linear.reset(harmonics_);
  spans_.clear();
  for (std::vector<Stretch> &run : run_) run.clear();
  if (!std::all_of(X, X + 3 * n, [](double x) { return std::isfinite(x); })) return;
  instants_.clear();
  std::copy_n(X + 2 * n, n, p_.begin());
  p_[0] += 2 * (standstill.x[2] - point.gap);
  approach_.combine(1, p_.data(), 0, p_.data());
  if (approach_.mean() + approach_.bound(0) <= 0) { // never closed
    activity.open = 1;
    for (int d = 0; d < 3; ++d) G[d * n] = -2 * standstill.force[d];
    return;
  }
  std::array<double, 2> v{};
  for (int d = 0; has_friction(point.law) && d < 2; ++d) {
    v[d] = point.kt[d] * (standstill.w[d] - standstill.x[d]);
    sliders_[d].set(point.kt[d], point.mu[d] * point.kn, X + d * n, p_.data());
  }
  if (surely_stuck(point, v)) {
    linear.springs_only = true;
    linear.multiply(point, X, G);
    G[2 * n] += 2 * (point.kn * (standstill.x[2] - point.gap) - standstill.force[2]);
    return;
  }
  grid_.sample(p_.data(), 0, grid_.cells - 1, &values_[2 * ends], &slopes_[2 * ends]);
  find_spans();
  activity.open = 1;
  for (const Span &span : spans_) activity.open -= (span.end - span.begin) / period;
  normal(point, G, linear);
  activity.events = always_closed_ ? 0 : 2 * static_cast<int>(spans_.size());
  for (int d = 0; d < 2; ++d) {
    if (!has_friction(point.law) || point.mu[d] == 0) continue; // slips without force
    sample_closed(X + d * n, &values_[d * ends], &slopes_[d * ends]);
    sliders_[d].on_grid(&values_[d * ends], &slopes_[d * ends], &values_[2 * ends], &slopes_[2 * ends]);
    march(d, v[d]);
    tangential(point, d, X, G, linear);
    activity.events += changes(d);
  }
  if (has_friction(point.law)) activity.slip = slipping();
  linear.springs_only = always_closed_ && (!has_friction(point.law) || (rests(0) && rests(1)));
  for (int d = 0; d < 3; ++d) G[d * n] -= 2 * standstill.force[d];
  activity.dissipation = dissipation(harmonics_, X, G);
}

// On the grid where the point is closed, and one cell about that.
void ExactLaw::sample_closed(const double *x, double *value, double *slope) const {
  if (grid_.samples_all()) return grid_.sample(x, 0, grid_.cells - 1, value, slope);
  for (const Span &span : spans_) {
    const int first = static_cast<int>(span.begin / grid_.width) - 1,
              last = static_cast<int>(span.end / grid_.width) + 1;
    grid_.sample(x, first, std::min(last, grid_.cells - 1), value, slope);
    if (last >= grid_.cells) grid_.sample(x, 0, last - grid_.cells, value, slope);
  }
}

// By bounds alone, without looking for instants.
bool ExactLaw::surely_stuck(const ContactPoint &point, const std::array<double, 2> &v) const {
  if (approach_.mean() - approach_.bound(0) <= 0) return false;
  for (int d = 0; has_friction(point.law) && d < 2; ++d)
    if (point.mu[d] == 0 || !sliders_[d].rests(v[d])) return false;
  return true;
}

// On w_p, all round.
bool ExactLaw::rests(int direction) const {
  const std::vector<Stretch> &run = run_[direction];
  return run.size() == 1 && run[0].side == 0 && run[0].set_at < 0;
}

// When the contact is closed, from the zeros of p.
void ExactLaw::find_spans() {
  const double *p = &values_[2 * grid_.ends];
  const double above = grid_.width * grid_.width / 8 * approach_.bound(2);
  const bool closed_at_first = p[0] > 0;
  bool closed = closed_at_first;
  int first_lift_off = -1;
  const auto change = [&](double at, int instant) {
    if (!closed)
      spans_.push_back({at, 0, instant, 0});
    else if (!spans_.empty())
      spans_.back().end = at, spans_.back().to = instant;
    else
      first_lift_off = instant;
    closed = !closed;
  };
  const double size = std::abs(approach_.mean()) + approach_.bound(0) + approach_.bound(1);
  bool whole = p[0] != 0;
  double t = -1;
  for (int j = 0, events = 0; j < grid_.cells;) {
    const double sign = closed ? 1 : -1;
    if (whole && std::min(sign * p[j], sign * p[j + 1]) > above) {
      t = Falling::none;
    } else {
      CellPolynomial p_here;
      grid_.expand(approach_, j, p_here);
      const Falling gap(p_here, sign, 0, size);
      t = whole ? gap.first_in_cell() : gap.first(t, 1);
    }
    if (t < Falling::none && ++events <= most_events) {
      const int now = instants_.add(j, t);
      change(instants_[now].theta, now);
      whole = false;
    } else {
      t = -1, whole = true, events = 0, ++j;
    }
  }
  if (closed != closed_at_first) change(period, 0); // a zero at the very end of the period
  always_closed_ = closed_at_first && first_lift_off < 0;
  if (always_closed_)
    spans_.push_back({0, period, 0, 0});
  else if (closed_at_first)
    spans_.back().end = period + instants_[first_lift_off].theta, spans_.back().to = first_lift_off;
}

// Stretches of one direction over all spans. An open contact forgets. One that never opens goes round once from where
// its place is known, if it slips both ways in every round, else twice from w_p.
void ExactLaw::march(int direction, double v) {
  Slider &slider = sliders_[direction];
  std::vector<Stretch> &run = run_[direction];
  if (spans_.empty()) return;
  if (!always_closed_) {
    for (const Span &span : spans_) {
      const double landed = slider.landed(span.from);
      slider.march(sticking(landed, span.from, 0), span.begin, span.from, span.end, span.to, run);
    }
    return;
  }
  if (const int turn = slider.turning_point(); turn >= 0) {
    const double at = instants_[turn].theta, left = slider.left_by(1, turn);
    const Stretch last = slider.march(sticking(left, turn, 1), at, turn, at + period, turn, run);
    if (last.side == 1 || (last.side == 0 && std::abs(last.v - left) <= 100 * slider.tiny(left))) {
      run.back().end = at + period, run.back().to = turn; // it may have been found once more, a hair before
      begin_at_zero(run);
      return;
    }
    run.clear();
  }
  first_round_.clear();
  Stretch state = sticking(v, -1, 0);
  state.side = slider.overrun(v);
  state = slider.march(state, 0, 0, period, 0, first_round_);
  if (state.side == 0 && state.set_at < 0)
    run = first_round_; // stuck on w_p all round: the second round would repeat the first
  else
    slider.march(state, 0, 0, period, 0, run, &first_round_);
}

void ExactLaw::add(double begin, int from, double end, int to, double weight, MaskMeans &mask) const {
  const Instant &a = instants_[from], &b = instants_[to];
  mask.cosine[0] += weight * (end - begin) / period;
  integrate(coefficient_count(harmonics_), inverse_.data(), a.cosine.data(), a.sine.data(), b.cosine.data(),
            b.sine.data(), weight, mask.cosine.data(), mask.sine.data());
}

void ExactLaw::normal(const ContactPoint &point, double *G, Linearisation &linear) const {
  for (const Span &span : spans_) add(span.begin, span.from, span.end, span.to, 1, linear.closed);
  linear.spans = static_cast<int>(spans_.size());
  if (always_closed_) linear.closed.set_whole();
  linear.closed.add_gram_times(point.kn, p_.data(), G + 2 * coefficient_count(harmonics_));
}

// T = k_t x - v while it sticks, side mu k_n p while it slips.
void ExactLaw::tangential(const ContactPoint &point, int d, const double *X, double *G, Linearisation &linear) {
  const std::vector<Stretch> &run = run_[d];
  const int n = coefficient_count(harmonics_);
  for (const Stretch &s : run)
    if (s.side != 0) add(s.begin, s.from, s.end, s.to, s.side, linear.slip[d]);
  for (std::size_t i = 0; i < run.size(); ++i)
    if (run[i].side == 0) add_stick(point, d, i, G + d * n, linear);
  linear.stick[d].add_gram_times(point.kt[d], X + d * n, G + d * n);
  linear.slip[d].add_gram_times(point.mu[d] * point.kn, p_.data(), G + d * n);
}

// Part of one stick stretch; a stretch that began before the period's end goes on at its beginning.
void ExactLaw::add_stick(const ContactPoint &point, int d, std::size_t i, double *G, Linearisation &linear) {
  const std::vector<Stretch> &run = run_[d];
  const Stretch &s = run[i];
  const bool set = s.set_at >= 0, last = i > 0 && i + 1 == run.size();
  const auto same = [&](const Stretch &other) { return set && other.side == 0 && other.set_at == s.set_at; };
  add(s.begin, s.from, s.end, s.to, 1, linear.stick[d]);
  if (i == 0 && run.size() > 1 && same(run.back())) return;
  Linearisation::Run *hung = set ? &linear.add_run(d) : nullptr;
  std::vector<double> &share = set ? hung->share : share_;
  share.assign(coefficient_count(harmonics_), 0.0);
  const auto add_share_of = [&](const Stretch &part) {
    const Instant &from = instants_[part.from], &to = instants_[part.to];
    share[0] += 2 * (part.end - part.begin) / period;
    add_share(harmonics_, inverse_.data(), from.cosine.data(), from.sine.data(), to.cosine.data(), to.sine.data(),
              share.data());
  };
  add_share_of(s);
  if (last && same(run[0])) add_share_of(run[0]);
  for (std::size_t k = 0; k < share.size(); ++k) G[k] -= s.v * share[k];
  if (!set) return;
  // v = k_t x - side mu k_n p after a slip; after a landing v = k_t x at an instant that moves by -dx_n / x_n'
  const double by_n = s.set_by != 0 ? s.set_by * point.mu[d] * point.kn : sliders_[d].landing_slope(s.set_at);
  const Instant &at = instants_[s.set_at];
  scale_rows(harmonics_, at.cosine.data(), at.sine.data(), -point.kt[d], by_n, hung->by_t.data(), hung->by_n.data());
}

// Changes between stick and slip within the spans, one of them perhaps just where the period begins.
int ExactLaw::changes(int d) const {
  int count = always_closed_ && run_[d].front().side != run_[d].back().side ? 1 : 0;
  for (std::size_t i = 1; i < run_[d].size(); ++i)
    count += run_[d][i].side != run_[d][i - 1].side && run_[d][i].from == run_[d][i - 1].to;
  return count;
}

// Share of the period in which at least one direction slips; both runs cover the same spans in the same order.
double ExactLaw::slipping() const {
  double closed = 0, both_stick = 0;
  for (const Span &span : spans_) closed += span.end - span.begin;
  for (std::size_t i = 0, j = 0; i < run_[0].size() && j < run_[1].size();) {
    const Stretch &a = run_[0][i], &b = run_[1][j];
    if (a.side == 0 && b.side == 0) both_stick += std::max(0.0, std::min(a.end, b.end) - std::max(a.begin, b.begin));
    (a.end < b.end ? i : j)++;
  }
  return (closed - both_stick) / period;
}

} // namespace dovetail
