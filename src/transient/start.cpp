#include "transient/start.hpp"

#include <algorithm>
#include <cmath>

#include "contact/fourier.hpp"
#include "contact/law_traits.hpp"

namespace dovetail {
namespace {

// The sliders after that motion went round twice: law.hpp over dense samples.
std::vector<Memory> dragged(const DenseModel &model, const std::vector<double> &coefficients, int harmonics) {
  constexpr int samples = 2048;
  const Fourier fourier(harmonics, std::max(samples, 8 * harmonics));
  const int N = fourier.samples(), width = fourier.size();
  std::vector<Memory> all;
  std::vector<double> x(3 * N);
  for (int point = 0; point < model.points; ++point) {
    const ContactPoint &law = model.contact[point];
    const Standstill &rest = model.standstill[point];
    for (int d = 0; d < 3; ++d) {
      fourier.synthesise(&coefficients[(model.modes + 3 * point + d) * width], &x[d * N]);
      for (int j = 0; j < N; ++j) x[d * N + j] += rest.x[d];
    }
    Memory w = rest.w;
    for (int step = 0; step <= 2 * N && has_friction(law.law); ++step) { // ends at theta = 0
      const int j = step % N;
      const double bound = pressed(law.kn, x[2 * N + j] - law.gap);
      std::array<double, 2> T{law.kt[0] * (x[j] - w[0]), law.kt[1] * (x[N + j] - w[1])}, along;
      const std::array<double, 2> trial = T;
      if (!shares_slider(law.law))
        for (int d = 0; d < 2; ++d) T[d] = rubbed(T[d], law.mu[d] * bound);
      else if (slips(std::hypot(T[0], T[1]), law.mu[0] * bound))
        drawn_back(law.mu[0] * bound, T, along);
      for (int d = 0; d < 2; ++d)
        if (T[d] != trial[d]) w[d] = x[d * N + j] - T[d] / law.kt[d];
    }
    all.push_back(w);
  }
  return all;
}

} // namespace

Flow::State state_of(const Flow &flow, const std::vector<double> &coefficients) {
  const int n = flow.modes().count, width = static_cast<int>(coefficients.size()) / n, harmonics = width / 2;
  std::vector<double> q(n), v(n);
  for (int i = 0; i < n; ++i) {
    const double *a = &coefficients[i * width];
    q[i] = a[0] / 2;
    for (int k = 1; k <= harmonics; ++k) q[i] += a[cosine(k)], v[i] += k * flow.omega() * a[sine(k)];
  }
  return flow.state({q, v, dragged(flow.model(), coefficients, harmonics)});
}

} // namespace dovetail
