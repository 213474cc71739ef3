#include "stability/finer_motion.hpp"

#include <cmath>

#include "contact/fourier.hpp"
#include "support/dense.hpp"

namespace dovetail {
namespace {

// K with the share of the period that each contact spring is at work.
std::vector<double> mean_stiffness(const DenseModel &model, const ContactReading &reading) {
  const int n = model.dofs();
  std::vector<double> K = model.K;
  for (int p = 0; p < model.points; ++p) {
    const ContactPoint &point = model.contact[p];
    const Linearisation &linear = reading.linear(p);
    const auto add = [&](int row, int column, double k) {
      K[static_cast<std::size_t>(model.modes + 3 * p + row) * n + model.modes + 3 * p + column] += k;
    };
    const bool springs = linear.springs_only;
    add(2, 2, point.kn * (springs ? 1 : linear.closed.cosine[0]));
    for (int d = 0; has_friction(point.law) && d < 2; ++d) {
      add(d, d, point.kt[d] * (springs ? 1 : linear.stick[d].cosine[0]));
      if (!springs) add(d, 2, point.mu[d] * point.kn * linear.slip[d].cosine[0]);
    }
  }
  return K;
}

} // namespace

std::vector<double> finer_motion(const DenseModel &model, const ContactReading &reading,
                                 const std::vector<double> &motion, double omega, double &change) {
  const int n = model.dofs(), all = reading.harmonics(), w = coefficient_count(all);
  const std::vector<double> K = mean_stiffness(model, reading);
  std::vector<double> finer = motion, answer(2 * n);
  double added = 0, size = 0;
  Dense A;
  Factors factors;
  for (int k = 1; k <= all; ++k) {
    if (k <= all / 2) {
      for (int r = 0; r < n; ++r) size += std::pow(motion[r * w + cosine(k)], 2) + std::pow(motion[r * w + sine(k)], 2);
      continue;
    }
    A.reset(2 * n, 2 * n);
    const double turn = k * omega;
    for (int r = 0; r < n; ++r)
      for (int c = 0; c < n; ++c) {
        const std::size_t at = static_cast<std::size_t>(r) * n + c;
        A(r, c) = A(n + r, n + c) = K[at] - turn * turn * model.M[at];
        A(r, n + c) = turn * model.viscous(at), A(n + r, c) = -A(r, n + c);
      }
    std::fill(answer.begin(), answer.end(), 0.0);
    for (int d = 0; d < 3 * model.points; ++d) {
      const double *force = &reading.force()[static_cast<std::size_t>(d) * w];
      answer[model.modes + d] = -force[cosine(k)], answer[n + model.modes + d] = -force[sine(k)];
    }
    if (!factors.factor(A)) continue;
    factors.solve(answer.data());
    for (int r = 0; r < n; ++r) {
      finer[r * w + cosine(k)] = answer[r], finer[r * w + sine(k)] = answer[n + r];
      added += answer[r] * answer[r] + answer[n + r] * answer[n + r];
    }
  }
  change = size > 0 ? std::sqrt(added / size) : 0;
  return finer;
}

} // namespace dovetail
