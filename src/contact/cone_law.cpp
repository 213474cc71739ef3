#include "contact/cone_law.hpp"

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "contact/cone_step.hpp"

namespace dovetail {
namespace {

// out (n, width) += row (n) times slopes (width).
DOVETAIL_WIDE void add_product(int n, int width, const double *row, const double *slopes, double *out) {
  for (int i = 0; i < n; ++i, out += width)
    for (int l = 0; l < width; ++l) out[l] += row[i] * slopes[l];
}

} // namespace

ConeLaw::ConeLaw(int harmonics, int samples)
    : fourier_(harmonics, samples), motion_(3 * samples), force_(3 * samples), states_(samples),
      slopes_(6 * fourier_.size()), sums_(6 * fourier_.size() * fourier_.size()),
      pressures_(fourier_.size() * fourier_.size()) {}

void ConeLaw::evaluate(const ContactPoint &point, const Standstill &standstill, const double *X, double *G,
                       Activity &activity, Linearisation *linear) {
  const int n = fourier_.size(), N = fourier_.samples();
  for (int d = 0; d < 3; ++d) {
    const double origin = standstill.x[d] - (d == 2 ? point.gap : 0);
    fourier_.synthesise(X + d * n, &motion_[d * N]);
    for (int j = 0; j < N; ++j) motion_[d * N + j] += origin;
  }
  for (int j = 0; j < N; ++j) force_[2 * N + j] = pressed(point.kn, motion_[2 * N + j]);
  march(point, standstill, linear);
  for (int d = 0; d < 3; ++d) {
    fourier_.analyse(&force_[d * N], G + d * n);
    G[d * n] -= 2 * standstill.force[d];
  }
  record(activity);
  activity.dissipation = dissipation(fourier_.harmonics(), X, G);
  if (!linear) return;
  linear->reset(fourier_.harmonics());
  write_blocks(linear->dense);
}

// Two sliders on their own have closed their loop after one round: whatever a period does to the memory is a clamp,
// which changes nothing the second time. In the plane the memory may creep up to its loop round by round.
int ConeLaw::rounds_to_close(const ContactPoint &point, const Standstill &standstill) {
  const int N = fourier_.samples();
  const double *normal = &force_[2 * N];
  const double close = 1e-10 * point.mu[0] * *std::max_element(normal, normal + N);
  std::array<double, 2> before{};
  for (int round = 0; round < most_rounds; ++round) {
    bool eventless = true; // stuck on w_p all round: the second round would repeat the first
    for (int j = 0; j < N; ++j) eventless = step(point, standstill, round, j, false) == State::stick && eventless;
    if (round == 0 && eventless) return 1;
    if (round > 0 && std::hypot(T_[0] - before[0], T_[1] - before[1]) <= close) return round + 1;
    before = T_;
  }
  return most_rounds;
}

void ConeLaw::march(const ContactPoint &point, const Standstill &standstill, bool differentiate) {
  const int n = fourier_.size(), N = fourier_.samples(), rounds = rounds_to_close(point, standstill);
  if (!differentiate) return; // the forces of the last round stand
  std::fill(sums_.begin(), sums_.end(), 0.0);
  std::fill(pressures_.begin(), pressures_.end(), 0.0);
  for (int round = 0; round < rounds; ++round)
    for (int j = 0; j < N; ++j) {
      if (step(point, standstill, round, j, true) == State::open || round + 1 < rounds) continue;
      for (int d = 0; d < 2; ++d) add_product(n, 3 * n, fourier_.row(j), &slopes_[3 * d * n], &sums_[3 * d * n * n]);
      add_product(n, n, fourier_.row(j), fourier_.row(j), pressures_.data());
    }
  for (double &value : pressures_) value *= point.kn;
}

ConeLaw::State ConeLaw::step(const ContactPoint &point, const Standstill &standstill, int round, int sample,
                             bool differentiate) {
  const int n = fourier_.size(), N = fourier_.samples();
  State state = State::open;
  if (!(motion_[2 * N + sample] > 0)) {
    T_ = {};
    std::fill(slopes_.begin(), slopes_.end(), 0.0);
  } else if (round == 0 && sample == 0) { // from the memory of the preload
    std::fill(slopes_.begin(), slopes_.end(), 0.0);
    for (int d = 0; d < 2; ++d) {
      T_[d] = point.kt[d] * (motion_[d * N] - standstill.w[d]);
      for (int i = 0; i < n; ++i) slopes_[(3 * d + d) * n + i] = point.kt[d] * fourier_.row(0)[i];
    }
    state = State::stick;
    if (slips_forth(std::hypot(T_[0], T_[1]), point.mu[0] * force_[2 * N])) {
      state = State::slip;
      slide(point, differentiate);
    }
  } else {
    state = differentiate ? advance<Jet<inputs>>(point, sample) : advance<double>(point, sample);
  }
  for (int d = 0; d < 2; ++d) force_[d * N + sample] = T_[d];
  return states_[sample] = state;
}

// T at the sample from T before, by T, the displacements' increments and the normal displacements before and now.
template <class Real> ConeLaw::State ConeLaw::advance(const ContactPoint &point, int sample) {
  constexpr bool differentiate = !std::is_same_v<Real, double>;
  const int N = fourier_.samples(), before = sample ? sample - 1 : N - 1;
  const auto input = [](double value, [[maybe_unused]] int i) {
    if constexpr (differentiate)
      return Real::variable(value, i);
    else
      return value;
  };
  const double *p = &motion_[2 * N];
  const Real p0 = input(p[before], 4), p1 = input(p[sample], 5), stiffness(point.mu[0] * point.kn);
  const bool lands = !(p[before] > 0);
  const Real part = lands ? p1 / (p1 - p0) : Real(1); // of the step: since the landing
  std::array<Real, 2> T, y;
  for (int d = 0; d < 2; ++d) {
    T[d] = lands ? Real(0) : input(T_[d], d);
    y[d] = part * Real(point.kt[d]) * input(motion_[d * N + sample] - motion_[d * N + before], 2 + d);
  }
  const bool slips = cone_step(T, y, lands ? Real(0) : stiffness * p0, stiffness * p1);
  if constexpr (differentiate) chain({T[0].by, T[1].by}, fourier_.row(before), fourier_.row(sample));
  for (int d = 0; d < 2; ++d) T_[d] = value_of(T[d]);
  return slips ? State::slip : State::stick;
}

// slopes_ of the sample before become those of this one.
void ConeLaw::chain(const std::array<std::array<double, inputs>, 2> &by, const double *then, const double *now) {
  const int n = fourier_.size();
  double *first = slopes_.data(), *second = first + 3 * n;
  for (int l = 0; l < 3 * n; ++l) {
    const double a = first[l], b = second[l];
    first[l] = by[0][0] * a + by[0][1] * b, second[l] = by[1][0] * a + by[1][1] * b;
  }
  for (int d = 0; d < 2; ++d)
    for (int i = 0; i < n; ++i) {
      double *at = &slopes_[3 * d * n + i];
      at[0] += by[d][2] * (now[i] - then[i]), at[n] += by[d][3] * (now[i] - then[i]);
      at[2 * n] += by[d][4] * then[i] + by[d][5] * now[i];
    }
}

// The first force, if it is beyond the bound: T = mu N e, dT = mu dN e + mu N / size (1 - e e') d trial.
void ConeLaw::slide(const ContactPoint &point, bool differentiate) {
  const int n = fourier_.size(), N = fourier_.samples();
  const double mu = point.mu[0];
  std::array<double, 2> e;
  const double shrink = drawn_back(mu * force_[2 * N], T_, e);
  if (!differentiate) return;
  double *first = slopes_.data(), *second = first + 3 * n;
  for (int l = 0; l < 3 * n; ++l) {
    const double along = e[0] * first[l] + e[1] * second[l];
    first[l] = shrink * (first[l] - along * e[0]);
    second[l] = shrink * (second[l] - along * e[1]);
  }
  const double *row = fourier_.row(0);
  for (int i = 0; i < n; ++i) {
    first[2 * n + i] += mu * point.kn * e[0] * row[i];
    second[2 * n + i] += mu * point.kn * e[1] * row[i];
  }
}

// Shares and events of the last round, as if it went on for ever.
void ConeLaw::record(Activity &activity) const {
  const int N = fourier_.samples();
  activity.events = 0;
  for (int j = 0; j < N; ++j) activity.events += states_[j] != states_[j ? j - 1 : N - 1];
  activity.open = static_cast<double>(std::count(states_.begin(), states_.end(), State::open)) / N;
  activity.slip = static_cast<double>(std::count(states_.begin(), states_.end(), State::slip)) / N;
}

// In the order of block_places: rows t1 and t2 by t1, t2, n; row n by n.
void ConeLaw::write_blocks(std::vector<double> &dense) const {
  const int n = fourier_.size();
  dense.resize(7 * n * n);
  double *to = dense.data();
  const auto take = [&](const double *from, int stride) {
    for (int i = 0; i < n; ++i, from += stride) {
      const double scale = (i == 0 ? 4.0 : 2.0) / fourier_.samples(); // the rows of the synthesis hold 1/2 for a0
      for (int l = 0; l < n; ++l) *to++ = scale * from[l];
    }
  };
  for (int d = 0; d < 2; ++d)
    for (int column = 0; column < 3; ++column) take(&sums_[3 * d * n * n + column * n], 3 * n);
  take(pressures_.data(), n);
}

} // namespace dovetail
