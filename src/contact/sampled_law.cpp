#include "contact/sampled_law.hpp"

#include <algorithm>

namespace dovetail {

SampledLaw::SampledLaw(int harmonics, int samples)
    : fourier_(harmonics, samples), tangential_(samples), closing_(samples), force_(samples) {
  const int n = fourier_.size();
  for (auto *sums : {&stick_sums_, &slip_sums_, &run_sums_}) sums->resize(2 * n);
  for (auto *row : {&share_, &by_xt_, &by_xn_}) row->resize(n);
}

State SampledLaw::evaluate(const ContactPoint &point, const Standstill &preload, const double *X, double *G,
                           double *dG) {
  const int n = fourier_.size(), N = fourier_.samples(), width = 3 * n;
  if (dG) std::fill_n(dG, width * width, 0.0);

  fourier_.synthesise(X + 2 * n, closing_.data());
  bool opens = false, slips = false;
  for (int j = 0; j < N; ++j) {
    closing_[j] += preload.x[2] - point.gap;
    force_[j] = point.kn * std::max(0.0, closing_[j]);
    opens = opens || !(closing_[j] > 0);
  }
  fourier_.analyse(force_.data(), G + 2 * n);
  if (dG) {
    std::fill(stick_sums_.begin(), stick_sums_.end(), 0.0);
    for (int a = 0, b; a < N; a = b) {
      const bool closed = closing_[a] > 0;
      for (b = a + 1; b < N && (closing_[b] > 0) == closed; ++b) {
      }
      if (closed) fourier_.add_sums(a, b, 1, stick_sums_.data());
    }
    fourier_.add_gram(stick_sums_.data(), point.kn, dG + 2 * n * (width + 1), width);
  }

  for (int d = 0; d < 2; ++d) {
    fourier_.synthesise(X + d * n, tangential_.data());
    for (double &x : tangential_) x += preload.x[d];
    march(point.kt[d], point.mu[d] * point.kn, preload.w[d]);
    fourier_.analyse(force_.data(), G + d * n);
    for (const Run &run : runs_) slips = slips || run.state == State::slip;
    if (dG) differentiate(point.kt[d], point.mu[d] * point.kn, dG + d * n * (width + 1), dG + d * n * width + 2 * n);
  }
  for (int d = 0; d < 3; ++d) G[d * n] -= 2 * preload.force[d];
  return opens ? State::open : slips ? State::slip : State::stick;
}

// Fills force_ and runs_ of one tangential direction.
void SampledLaw::march(double kt, double mu_kn, double w) {
  const int N = fourier_.samples();
  Anchor anchor;
  runs_.clear();
  for (int round = 0; round < 2; ++round) {
    bool eventless = true;
    for (int j = 0; j < N; ++j) {
      State state = State::open;
      force_[j] = 0;
      if (closing_[j] > 0) {
        const int before = j > 0 ? j - 1 : N - 1;
        if ((j > 0 || round > 0) && !(closing_[before] > 0)) { // the memory restarts at the instant of contact
          const double part = closing_[before] / (closing_[before] - closing_[j]);
          w = tangential_[before] + part * (tangential_[j] - tangential_[before]);
          anchor = {Anchor::Kind::landing, j, 0};
        }
        const Slide slid = slide(tangential_[j], kt, mu_kn * closing_[j], w);
        force_[j] = slid.force;
        state = slid.sign ? State::slip : State::stick;
        if (slid.sign) anchor = {Anchor::Kind::slip, j, slid.sign};
      }
      eventless = eventless && state == State::stick;
      if (round == 0) continue;
      const bool goes_on = !runs_.empty() && runs_.back().state == state &&
                           (state == State::open || (state == State::slip && runs_.back().anchor.sign == anchor.sign) ||
                            (state == State::stick && runs_.back().anchor.sample == anchor.sample));
      if (goes_on)
        runs_.back().end = j + 1;
      else
        runs_.push_back({j, j + 1, state, anchor});
    }
    if (eventless && round == 0) { // stuck on w_p all round: the second round would repeat the first
      runs_.push_back({0, N, State::stick, anchor});
      return;
    }
  }
}

// The runs of the last march give d T / d X without any product over samples: a Toeplitz + Hankel block for the stick
// samples and one for the slip samples, and a rank-one term for each stick run, which hangs on its anchor.
void SampledLaw::differentiate(double kt, double mu_kn, double *dT_dxt, double *dT_dxn) {
  const int n = fourier_.size(), width = 3 * n;
  std::fill(stick_sums_.begin(), stick_sums_.end(), 0.0);
  std::fill(slip_sums_.begin(), slip_sums_.end(), 0.0);
  for (const Run &run : runs_) {
    if (run.state == State::slip) fourier_.add_sums(run.begin, run.end, run.anchor.sign, slip_sums_.data());
    if (run.state != State::stick) continue;
    std::fill(run_sums_.begin(), run_sums_.end(), 0.0);
    fourier_.add_sums(run.begin, run.end, 1, run_sums_.data());
    for (int i = 0; i < 2 * n; ++i) stick_sums_[i] += run_sums_[i];
    if (run.anchor.kind == Anchor::Kind::memory) continue;
    fourier_.indicator(run_sums_.data(), share_.data());
    anchor_rows(run.anchor, kt, mu_kn);
    for (int i = 0; i < n; ++i)
      for (int l = 0; l < n; ++l) {
        dT_dxt[i * width + l] += share_[i] * by_xt_[l];
        dT_dxn[i * width + l] += share_[i] * by_xn_[l];
      }
  }
  fourier_.add_gram(stick_sums_.data(), kt, dT_dxt, width);
  fourier_.add_gram(slip_sums_.data(), mu_kn, dT_dxn, width);
}

// Derivative of the part of a stick force that hangs on the anchor: T_j = kt x_j + (this), by x_t and by x_n.
void SampledLaw::anchor_rows(const Anchor &anchor, double kt, double mu_kn) {
  const int n = fourier_.size(), j = anchor.sample, before = j > 0 ? j - 1 : fourier_.samples() - 1;
  const double *now = fourier_.row(j), *then = fourier_.row(before);
  if (anchor.kind == Anchor::Kind::slip) { // w = x_j - sign mu N_j / kt
    for (int i = 0; i < n; ++i) {
      by_xt_[i] = -kt * now[i];
      by_xn_[i] = anchor.sign * mu_kn * now[i];
    }
    return;
  }
  // w = x_then + part (x_now - x_then), part = p_then / (p_then - p_now)
  const double p0 = closing_[before], p1 = closing_[j], fall = p0 - p1, part = p0 / fall;
  const double slope = kt * (tangential_[j] - tangential_[before]) / (fall * fall);
  for (int i = 0; i < n; ++i) {
    by_xt_[i] = -kt * (then[i] + part * (now[i] - then[i]));
    by_xn_[i] = slope * (p1 * then[i] - p0 * now[i]);
  }
}

} // namespace dovetail
