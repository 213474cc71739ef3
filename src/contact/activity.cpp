#include "contact/activity.hpp"

#include <cmath>

#include "contact/fourier.hpp"

namespace dovetail {

double dissipation(int harmonics, const double *X, const double *G) {
  const int n = coefficient_count(harmonics);
  double sum = 0;
  for (int d = 0; d < 3; ++d)
    for (int k = 1; k <= harmonics; ++k)
      sum += k * (G[d * n + cosine(k)] * X[d * n + sine(k)] - G[d * n + sine(k)] * X[d * n + cosine(k)]);
  return M_PI * sum;
}

} // namespace dovetail
