#include "contact/contact_derivative.hpp"

#include <algorithm>
#include <utility>

namespace dovetail {

void ContactDerivative::write(int point, double *blocks) const {
  forces_->write(point, blocks);
  const int n = forces_->width();
  for (std::size_t b = 0; transposed_ && b < places(point).size(); ++b, blocks += n * n)
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < i; ++j) std::swap(blocks[i * n + j], blocks[j * n + i]);
}

void ContactDerivative::multiply(const double *V, double *out) const {
  if (!transposed_) return forces_->multiply(V, out);
  const int n = forces_->width();
  std::vector<double> blocks(9 * static_cast<std::size_t>(n) * n);
  std::fill_n(out, static_cast<std::size_t>(size()) * 3 * n, 0.0);
  for (int p = 0; p < size(); ++p, V += 3 * n, out += 3 * n) {
    write(p, blocks.data());
    const double *block = blocks.data();
    for (const BlockPlace &place : places(p))
      for (int i = 0; i < n; ++i, block += n)
        for (int j = 0; j < n; ++j) out[place.row * n + i] += block[j] * V[place.column * n + j];
  }
}

} // namespace dovetail
