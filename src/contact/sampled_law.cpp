#include "contact/sampled_law.hpp"

#include <algorithm>
#include <utility>

namespace dovetail {
namespace {

constexpr int word_size = 64;

// Parameters of the points in the lanes.
struct Sliders {
  Lanes kn{}, kt[2]{}, mu[2]{};
  Lanes offset[2]{}; // x_p - w_p
};

template <class B> inline bool any(const B &bits) {
  std::uint64_t all = 0;
  for (std::size_t lane = 0; lane < sizeof bits / sizeof all; ++lane) all |= bits[lane];
  return all;
}

// Normal force, and the bits of contact, from x_n - x_n0.
template <class V, class B>
inline void press_part(int samples, const V &kn, Part<const V> closing, Part<V> force, Part<B> closed) {
  for (int w = 0, j = 0; j < samples; ++w) {
    B bits{}, bit = B{} + 1;
    for (const int end = std::min(j + word_size, samples); j < end; ++j, bit += bit) {
      force[j] = pressed(kn, closing[j]);
      bits |= closing[j] > 0 ? bit : B{};
    }
    closed[w] = bits;
  }
}

template <int Width>
inline void press_parts(int samples, const Sliders &sliders, const Lanes *closing, Lanes *force, LaneBits *closed) {
  using V = typename Vector<Width>::Real;
  using B = typename Vector<Width>::Bits;
  for (int part = 0; part < lane_count / Width; ++part)
    press_part<V, B>(samples, Part<const V>(&sliders.kn, part)[0], {closing, part}, {force, part}, {closed, part});
}

// Twice round the period in force form (see `rubbed`). A point without an event in the first round starts the second as
// it did the first, and so repeats it to the bit. Where all points meet their first round again, the rest of the second
// is there already. motion, force (2, N); forth, back (2 rounds, 2 directions, words).
template <class V, class B>
inline void rub_part(int samples, Part<const V> stiffness, Part<const V> friction, Part<const V> offset,
                     Part<const V> motion, Part<const V> normal, Part<const B> closed, Part<V> force, Part<B> forth,
                     Part<B> back) {
  const int words = (samples + word_size - 1) / word_size;
  const V kt[2] = {stiffness[0], stiffness[1]}, mu[2] = {friction[0], friction[1]};
  const Part<const V> x[2] = {motion, motion + samples};
  const Part<V> T[2] = {force, force + samples};
  V start[2];
  for (int d = 0; d < 2; ++d) start[d] = kt[d] * (x[d][0] + offset[d]);
  V trial[2] = {start[0], start[1]};
  B events[2]{};
  for (int step = 0; step < 2 * words; ++step) {
    const bool again = step >= words;
    const int w = again ? step - words : step, begin = w * word_size, end = std::min(begin + word_size, samples);
    const V first[2] = {T[0][end - 1], T[1][end - 1]};
    B up[2]{}, down[2]{}, bit = B{} + 1;
    for (int j = begin; j < end; ++j, bit += bit) {
      const int next = j + 1 < samples ? j + 1 : 0;
      for (int d = 0; d < 2; ++d) {
        const V bound = mu[d] * normal[j], here = rubbed(trial[d], bound);
        up[d] |= slips_forth(trial[d], bound) ? bit : B{};
        down[d] |= slips_forth(-trial[d], bound) ? bit : B{};
        T[d][j] = here;
        trial[d] = here + kt[d] * (x[d][next] - x[d][j]);
      }
    }
    B differs{};
    for (int d = 0; d < 2; ++d) {
      for (int round = again; round < 2; ++round) {
        forth[(2 * round + d) * words + w] = up[d] & closed[w];
        back[(2 * round + d) * words + w] = down[d] & ~up[d] & closed[w];
      }
      differs |= first[d] != T[d][end - 1] ? ~B{} : B{};
      events[d] |= up[d] | down[d] | (closed[w] ^ ~std::uint64_t{0} >> (word_size - end + begin));
      if (step == words - 1) trial[d] = events[d] != 0 ? trial[d] : start[d];
    }
    if (again && !any(differs)) return;
  }
}

template <int Width>
inline void rub_parts(int samples, const Sliders &sliders, const Lanes *motion, const Lanes *normal,
                      const LaneBits *closed, Lanes *force, LaneBits *forth, LaneBits *back) {
  using V = typename Vector<Width>::Real;
  using B = typename Vector<Width>::Bits;
  for (int part = 0; part < lane_count / Width; ++part)
    rub_part<V, B>(samples, {sliders.kt, part}, {sliders.mu, part}, {sliders.offset, part}, {motion, part},
                   {normal, part}, {closed, part}, {force, part}, {forth, part}, {back, part});
}

DOVETAIL_WIDE_PARTS(press, (int samples, const Sliders &sliders, const Lanes *closing, Lanes *force, LaneBits *closed),
                    (samples, sliders, closing, force, closed))
DOVETAIL_WIDE_PARTS(rub,
                    (int samples, const Sliders &sliders, const Lanes *motion, const Lanes *normal,
                     const LaneBits *closed, Lanes *force, LaneBits *forth, LaneBits *back),
                    (samples, sliders, motion, normal, closed, force, forth, back))

// weight * (end - begin) added to the means of a mask: one interval of it.
DOVETAIL_WIDE void add_interval(int n, const double *__restrict begin, const double *__restrict end, double weight,
                                double *__restrict cosine, double *__restrict sine) {
  for (int m = 0; m < n; ++m) {
    cosine[m] += weight * (end[m] - begin[m]);
    sine[m] += weight * (end[n + m] - begin[n + m]);
  }
}

// share += the coefficients of the same interval's indicator
DOVETAIL_WIDE void add_share(int n, const double *__restrict begin, const double *__restrict end,
                             double *__restrict share) {
  share[0] += 2 * (end[0] - begin[0]);
  for (int k = 1; k <= n / 2; ++k) {
    share[cosine(k)] += 2 * (end[k] - begin[k]);
    share[sine(k)] += 2 * (end[n + k] - begin[n + k]);
  }
}

// out = a x + b y
DOVETAIL_WIDE void combine(int n, double a, const double *x, double b, const double *y, double *__restrict out) {
  for (int i = 0; i < n; ++i) out[i] = a * x[i] + b * y[i];
}

bool at(const std::uint64_t *bits, int j) { return bits[j / word_size] >> (j % word_size) & 1; }

// The last of the samples whose bits are set, -1 if there is none; `bits(word)`.
template <class Bits> int last_set(int words, Bits bits) {
  for (int w = words - 1; w >= 0; --w)
    if (const std::uint64_t word = bits(w)) return word_size * (w + 1) - 1 - __builtin_clzll(word);
  return -1;
}

// Visits the intervals [begin, end) of samples that the bits `edges(word)` part: a set bit begins an interval.
template <class Edges, class Visit> void each_interval(int samples, Edges edges, Visit visit) {
  int begin = 0;
  for (int first = 0; first < samples; first += word_size)
    for (std::uint64_t bits = edges(first / word_size); bits; bits &= bits - 1) {
      const int end = first + __builtin_ctzll(bits);
      if (end == 0 || end >= samples) continue;
      visit(begin, end);
      begin = end;
    }
  visit(begin, samples);
}

// Bits that differ from the sample before; before the first one comes the bit `carry`.
std::uint64_t changed(const std::uint64_t *bits, int word, bool carry) {
  return bits[word] ^ (bits[word] << 1 | (word ? bits[word - 1] >> (word_size - 1) : carry));
}

// Shares and events of a round, as if it went on for ever. forth, back (2 directions).
DOVETAIL_WIDE void count_states(int samples, const std::uint64_t *closed, const std::uint64_t *const *forth,
                                const std::uint64_t *const *back, const std::array<double, 2> &mu, Activity &activity) {
  const int words = (samples + word_size - 1) / word_size;
  int in_contact = 0, slipping = 0, events = 0;
  const auto edges = [&](const std::uint64_t *bits, int w) {
    const int inside = std::min(samples - w * word_size, word_size);
    return changed(bits, w, at(bits, samples - 1)) & ~0ull >> (word_size - inside);
  };
  for (int w = 0; w < words; ++w) {
    const std::uint64_t passages = edges(closed, w), stays = closed[w] & ~passages; // here and one sample before
    in_contact += __builtin_popcountll(closed[w]);
    slipping += __builtin_popcountll(forth[0][w] | back[0][w] | forth[1][w] | back[1][w]);
    events += __builtin_popcountll(passages);
    for (int d = 0; d < 2; ++d) // without friction it slips for ever: there is no onset
      for (const std::uint64_t *bits : {forth[d], back[d]})
        if (mu[d] > 0) events += __builtin_popcountll(edges(bits, w) & stays);
  }
  activity.open = static_cast<double>(samples - in_contact) / samples;
  activity.slip = static_cast<double>(slipping) / samples;
  activity.events = events;
}

} // namespace

SampledLaw::SampledLaw(int harmonics, int samples)
    : fourier_(harmonics, samples), masks_(harmonics, samples), wide_(harmonics, samples),
      words_((samples + word_size - 1) / word_size), coefficients_(3 * fourier_.size()), motion_(3 * samples),
      force_(3 * samples), closed_(words_), forth_(4 * words_), back_(4 * words_), state_words_(9 * words_) {
  Words next = state_words_.data();
  const auto take = [&] { return std::exchange(next, next + words_); };
  states_.closed = take();
  for (auto *slip : {&states_.forth, &states_.back})
    for (auto &round : *slip)
      for (auto &direction : round) direction = take();
}

void SampledLaw::evaluate(const int *which, int count, const ContactPoint *points, const Standstill *standstill,
                          const double *X, double *G, Activity *activity, Linearisation *linear) {
  const int n = fourier_.size(), width = 3 * n;
  for (; count > 0; which += lane_count, count -= lane_count) {
    const int lanes = std::min(count, lane_count);
    march(which, lanes, points, standstill, X);
    for (int lane = 0; lane < lanes; ++lane) {
      const int p = which[lane];
      const double *x = X + p * width;
      double *g = G + p * width;
      for (int i = 0; i < width; ++i) g[i] = coefficients_[i][lane];
      for (int d = 0; d < 3; ++d) g[d * n] -= 2 * standstill[p].force[d];
      take_states(lane, has_friction(points[p].law));
      count_states(fourier_.samples(), states_.closed, states_.forth[1], states_.back[1], points[p].mu, activity[p]);
      activity[p].dissipation = dissipation(fourier_.harmonics(), x, g);
      if (linear) differentiate(points[p], lane, x, linear[p]);
    }
  }
}

// Motion and forces of a group, one point per lane; lanes to spare repeat the last point.
void SampledLaw::march(const int *which, int lanes, const ContactPoint *points, const Standstill *standstill,
                       const double *X) {
  const int n = fourier_.size(), N = fourier_.samples(), width = 3 * n;
  Sliders sliders;
  bool friction = false;
  for (int lane = 0; lane < lane_count; ++lane) {
    const int p = which[std::min(lane, lanes - 1)];
    const ContactPoint &point = points[p];
    const double *x = X + p * width;
    for (int i = 0; i < width; ++i) coefficients_[i][lane] = x[i];
    sliders.kn[lane] = point.kn;
    coefficients_[2 * n][lane] += 2 * (standstill[p].x[2] - point.gap);
    if (!has_friction(point.law)) continue;
    friction = true;
    for (int d = 0; d < 2; ++d) {
      sliders.kt[d][lane] = point.kt[d];
      sliders.mu[d][lane] = point.mu[d];
      sliders.offset[d][lane] = standstill[p].x[d] - standstill[p].w[d];
    }
  }
  const int rows = friction ? 3 : 1, row = 3 - rows;
  wide_.synthesise(rows, &coefficients_[row * n], &motion_[row * N]);
  press(N, sliders, &motion_[2 * N], &force_[2 * N], closed_.data());
  if (friction) {
    land();
    rub(N, sliders, motion_.data(), &force_[2 * N], closed_.data(), force_.data(), forth_.data(), back_.data());
  } else {
    std::fill_n(coefficients_.begin(), 2 * n, Lanes{});
  }
  wide_.analyse(rows, &force_[row * N], &coefficients_[row * n]);
}

// Where a point lands between two samples, the memory restarts at the instant of contact, interpolated. There is no
// tangential force at the open sample before, wherever the point is: it is moved to the place of landing.
void SampledLaw::land() {
  const int N = fourier_.samples();
  const LaneBits ends = closed_[(N - 1) / word_size] >> ((N - 1) % word_size) & 1;
  for (int w = 0; w < words_; ++w) {
    const LaneBits landings = closed_[w] & ~(closed_[w] << 1 | (w ? closed_[w - 1] >> (word_size - 1) : ends));
    for (int lane = 0; lane < lane_count; ++lane)
      for (std::uint64_t bits = landings[lane]; bits; bits &= bits - 1) {
        const int j = w * word_size + __builtin_ctzll(bits), before = j ? j - 1 : N - 1;
        const double p0 = motion_[2 * N + before][lane], p1 = motion_[2 * N + j][lane], part = p0 / (p0 - p1);
        for (Lanes *x : {&motion_[0], &motion_[N]}) x[before][lane] += part * (x[j][lane] - x[before][lane]);
      }
  }
}

void SampledLaw::take_states(int lane, bool friction) {
  for (int w = 0; w < words_; ++w) {
    states_.closed[w] = closed_[w][lane];
    for (int round = 0; round < 2; ++round)
      for (int d = 0; d < 2; ++d) {
        const int from = (2 * round + d) * words_ + w;
        states_.forth[round][d][w] = friction ? forth_[from][lane] : 0;
        states_.back[round][d][w] = friction ? back_[from][lane] : 0;
      }
  }
}

// Closed and stuck on w_p all round: so in the first round, and then in the second.
bool SampledLaw::eventless() const {
  const int N = fourier_.samples();
  for (int w = 0; w < words_; ++w) {
    if (~states_.closed[w] & ~0ull >> (word_size - std::min(N - w * word_size, word_size))) return false;
    for (int d = 0; d < 2; ++d)
      if (states_.forth[0][d][w] | states_.back[0][d][w]) return false;
  }
  return true;
}

// The intervals of the second round give d G / d X without any product over samples.
void SampledLaw::differentiate(const ContactPoint &point, int lane, const double *X, Linearisation &linear) {
  const int n = fourier_.size(), N = fourier_.samples();
  const std::uint64_t *closed = states_.closed;
  linear.reset(fourier_.harmonics());
  linear.springs_only = eventless();
  if (linear.springs_only) return;
  each_interval(
      N, [&](int w) { return changed(closed, w, false); },
      [&](int begin, int end) {
        if (at(closed, begin))
          add_interval(n, masks_.at(begin), masks_.at(end), 1, linear.closed.cosine.data(), linear.closed.sine.data());
      });
  for (int d = 0; has_friction(point.law) && d < 2; ++d) differentiate(point, lane, d, X, linear);
}

void SampledLaw::differentiate(const ContactPoint &point, int lane, int direction, const double *X,
                               Linearisation &linear) {
  const int n = fourier_.size(), N = fourier_.samples();
  const std::uint64_t *closed = states_.closed, *forth = states_.forth[1][direction],
                      *back = states_.back[1][direction];
  MaskMeans &stick = linear.stick[direction], &slip = linear.slip[direction];
  sticks_.clear();
  each_interval(
      N, [&](int w) { return changed(closed, w, false) | changed(forth, w, false) | changed(back, w, false); },
      [&](int begin, int end) {
        if (!at(closed, begin)) return;
        const int sign = at(forth, begin) - at(back, begin);
        MaskMeans &mask = sign ? slip : stick;
        add_interval(n, masks_.at(begin), masks_.at(end), sign ? sign : 1, mask.cosine.data(), mask.sine.data());
        if (!sign) sticks_.push_back({begin, end, anchor_before(direction, begin)});
      });
  if (sticks_.size() > 1 && sticks_.front().begin == 0 && sticks_.back().end == N &&
      sticks_.front().anchor.sample == sticks_.back().anchor.sample) { // one interval through the start of the period
    sticks_.front().begin = sticks_.back().begin - N;
    sticks_.pop_back();
  }
  for (const Stick &interval : sticks_)
    if (interval.anchor.sample >= 0) add_run(point, lane, direction, interval, X, linear);
}

// The last event before a stick interval of the second round that begins at `sample`.
SampledLaw::Anchor SampledLaw::anchor_before(int direction, int sample) const {
  const int N = fourier_.samples(), before = sample ? sample - 1 : N - 1, round = sample ? 1 : 0;
  const std::uint64_t *closed = states_.closed, *forth = states_.forth[round][direction],
                      *back = states_.back[round][direction];
  if (!at(closed, before)) return {sample, 0};
  const int slip = sample ? before : last_set(words_, [&](int w) { return forth[w] | back[w]; });
  const int landing =
      sample ? -1 : last_set(words_, [&](int w) { return closed[w] & changed(closed, w, at(closed, 0)); });
  if (slip < landing) return {landing, 0};
  return {slip, slip < 0 ? 0 : at(forth, slip) - at(back, slip)};
}

void SampledLaw::add_run(const ContactPoint &point, int lane, int direction, const Stick &stick, const double *X,
                         Linearisation &linear) const {
  const int n = fourier_.size(), N = fourier_.samples(), j = stick.anchor.sample, sign = stick.anchor.sign;
  const double kt = point.kt[direction], mu_kn = point.mu[direction] * point.kn;
  const double *now = fourier_.row(j), *then = fourier_.row(j ? j - 1 : N - 1);
  Linearisation::Run &run = linear.add_run(direction);
  std::fill(run.share.begin(), run.share.end(), 0.0);
  add_share(n, masks_.at(std::max(stick.begin, 0)), masks_.at(stick.end), run.share.data());
  if (stick.begin < 0) add_share(n, masks_.at(stick.begin + N), masks_.at(N), run.share.data()); // of the round before
  if (sign) { // v = kt x - sign mu N at sample j
    combine(n, -kt, now, 0, then, run.by_t.data());
    combine(n, sign * mu_kn, now, 0, then, run.by_n.data());
    return;
  }
  // v = kt (x_then + part (x_now - x_then)), part = p_then / (p_then - p_now)
  const Lanes *closing = &motion_[2 * N];
  const double p0 = closing[j ? j - 1 : N - 1][lane], p1 = closing[j][lane], fall = p0 - p1, part = p0 / fall;
  double increment = 0;
  for (int i = 0; i < n; ++i) increment += (now[i] - then[i]) * X[direction * n + i];
  const double slope = kt * increment / (fall * fall);
  combine(n, -kt * part, now, -kt * (1 - part), then, run.by_t.data());
  combine(n, -slope * p0, now, slope * p1, then, run.by_n.data());
}

} // namespace dovetail
