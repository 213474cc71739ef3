#include "problems/amplitude.hpp"

#include <algorithm>
#include <cmath>
#include <complex>

#include "support/error.hpp"
#include "support/gathered.hpp"

namespace dovetail {
namespace {

constexpr int per_harmonic = 16, polishing_steps = 8; // as in python/dovetail/fourier.py
constexpr double near = 1e-11;                        // to the instant: the value is off by the square of it

struct Moment { // the deviation from the mean and its first two derivatives by theta
  double value, slope, bend;
};

Moment at(const double *c, int harmonics, double theta) {
  Moment m{};
  const std::complex<double> turn(std::cos(theta), std::sin(theta));
  std::complex<double> wave(1);
  for (int k = 1; k <= harmonics; ++k) {
    wave *= turn;
    const double a = c[cosine(k)], b = c[sine(k)], cos = wave.real(), sin = wave.imag();
    m.value += a * cos + b * sin, m.slope += k * (b * cos - a * sin), m.bend -= k * k * (a * cos + b * sin);
  }
  return m;
}

} // namespace

Swing::Swing(int harmonics)
    : harmonics_(harmonics), values_(std::max(64, per_harmonic * harmonics)), slopes_(values_.size()),
      grid_(harmonics, static_cast<int>(values_.size())) {}

// Instant at which sign * q is largest. Within half a step h of a grid point it is at most
// q_j + h/2 |q'_j| + h^2/8 sum k^2 |c_k|: only points where that reaches the largest grid value are polished.
double Swing::highest(const double *c, double sign) const {
  const double step = 2 * M_PI / values_.size(), mean = c[0] / 2;
  double curvature = 0, most = -HUGE_VAL;
  for (int k = 1; k <= harmonics_; ++k) curvature += k * k * std::hypot(c[cosine(k)], c[sine(k)]);
  for (const double value : values_) most = std::max(most, sign * (value - mean));
  double best = -HUGE_VAL, found = 0;
  for (std::size_t j = 0; j < values_.size(); ++j) {
    const double reach = step / 2 * std::abs(slopes_[j]) + step * step / 8 * curvature;
    if (sign * (values_[j] - mean) + reach < most) continue;
    const double start = j * step;
    double theta = start;
    for (int i = 0; i <= polishing_steps; ++i) {
      const Moment m = at(c, harmonics_, theta);
      if (sign * m.value > best) best = sign * m.value, found = theta;
      const double move = sign * m.bend < 0 ? -m.slope / m.bend : std::copysign(step / 4, sign * m.slope);
      const double next = std::clamp(theta + move, start - step / 2, start + step / 2);
      if (std::abs(next - theta) < near) break;
      theta = next;
    }
  }
  return found;
}

Swing::Extremes Swing::extremes(const double *c) {
  grid_.sample(c, values_.data(), slopes_.data());
  return {highest(c, 1), highest(c, -1)};
}

double Swing::amplitude(const double *c) {
  const Extremes found = extremes(c);
  return (at(c, harmonics_, found.high).value - at(c, harmonics_, found.low).value) / 2;
}

AmplitudeMeter::AmplitudeMeter(const Layout &layout, const Watched &watched)
    : layout_(layout), watched_(watched), harmonics_((layout.width - 1) / 2), swing_(harmonics_) {}

// The instants do not matter for the slope at extremes.
Amplitude AmplitudeMeter::of_one(const double *c, const double *along) {
  const Swing::Extremes found = swing_.extremes(c);
  const auto half = [&](const double *of) {
    return (at(of, harmonics_, found.high).value - at(of, harmonics_, found.low).value) / 2;
  };
  return {half(c), half(along)};
}

Amplitude AmplitudeMeter::of_row(const double *y, const double *t) {
  const int width = layout_.width;
  std::vector<double> sums(2 * width, 0.0);
  for (PetscInt d = 0; d < layout_.own_dofs(); ++d) {
    watched_.row->add(layout_.number(d), y + d * width, width, sums.data());
    watched_.row->add(layout_.number(d), t + d * width, width, sums.data() + width);
  }
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), 2 * width, MPI_DOUBLE, MPI_SUM, layout_.comm);
  return of_one(sums.data(), sums.data() + width);
}

Amplitude AmplitudeMeter::operator()(Vec y, Vec t) {
  Amplitude found{-1, 0};
  const double *q, *u;
  check(VecGetArrayRead(y, &q), "measuring an amplitude");
  check(VecGetArrayRead(t, &u), "measuring an amplitude");
  for (PetscInt d = 0; d < layout_.own_dofs() && !watched_.row; ++d) {
    const bool mode = d < layout_.own_modes.size();
    if (watched_.dof >= 0 ? layout_.number(d) != watched_.dof : mode && layout_.points > 0) continue;
    const double *c = q + d * layout_.width;
    double bound = 0;
    for (int k = 1; k <= harmonics_; ++k) bound += std::hypot(c[cosine(k)], c[sine(k)]);
    if (bound <= found.value) continue;
    const Amplitude here = of_one(c, u + d * layout_.width);
    if (here.value > found.value) found = here;
  }
  if (watched_.row) found = of_row(q, u);
  check(VecRestoreArrayRead(t, &u), "measuring an amplitude");
  check(VecRestoreArrayRead(y, &q), "measuring an amplitude");
  if (watched_.row) return found;
  const std::vector<double> all = gathered(layout_.comm, MPI_DOUBLE, std::array{found.value, found.slope});
  for (std::size_t i = 0; i < all.size(); i += 2)
    if (all[i] > found.value || i == 0) found = {all[i], all[i + 1]};
  return {std::max(found.value, 0.0), found.slope};
}

} // namespace dovetail
