#include "contact/trigonometric.hpp"

#include <algorithm>
#include <cmath>

#include "contact/fourier.hpp"
#include "contact/wide.hpp"

namespace dovetail {
namespace {

constexpr int padded(int count) { return (count + lane_count - 1) / lane_count * lane_count; }

// Powers of exp(i theta): eight by doubling, the others from the eight before.
DOVETAIL_WIDE void powers(double c1, double s1, int count, double *__restrict c, double *__restrict s) {
  c[0] = 1, s[0] = 0, c[1] = c1, s[1] = s1;
  c[2] = c1 * c1 - s1 * s1, s[2] = 2 * c1 * s1;
  c[3] = c[2] * c1 - s[2] * s1, s[3] = s[2] * c1 + c[2] * s1;
  const double c4 = c[2] * c[2] - s[2] * s[2], s4 = 2 * c[2] * s[2];
  for (int i = 0; i < 4; ++i) c[4 + i] = c[i] * c4 - s[i] * s4, s[4 + i] = s[i] * c4 + c[i] * s4;
  const double c8 = c4 * c4 - s4 * s4, s8 = 2 * c4 * s4;
  for (int first = lane_count; first < count; first += lane_count)
    for (int i = first; i < first + lane_count; ++i) {
      c[i] = c[i - lane_count] * c8 - s[i - lane_count] * s8;
      s[i] = s[i - lane_count] * c8 + c[i - lane_count] * s8;
    }
}

// A vector of ends of cells at a time; tables and values have room for whole vectors.
template <int Width>
inline void sum_waves_parts(int harmonics, int ends, const double *table, const double *coefficients, double *value,
                            double *slope) {
  using V = typename Vector<Width>::Real;
  for (int j = 0; j < ends; j += Width) {
    V f = V{} + coefficients[0] / 2, f1{};
    for (int k = 1; k <= harmonics; ++k) {
      const double a = coefficients[cosine(k)], b = coefficients[sine(k)];
      const V c = load<V>(table + 2 * (k - 1) * ends + j), s = load<V>(table + (2 * k - 1) * ends + j);
      f += a * c + b * s;
      f1 += (k * b) * c - (k * a) * s;
    }
    store(f, value + j), store(f1, slope + j);
  }
}

// f (t) = sum_k (a c + b s) even_k(t) + (b c - a s) odd_k(t), with c, s at the middle of the cell.
template <int Width>
inline void sum_terms_parts(int stride, const double *a, const double *b, const double *c, const double *s,
                            const double *taylor, CellPolynomial &out) {
  using V = typename Vector<Width>::Real;
  constexpr int parts = lane_count / Width;
  V even[parts]{}, odd[parts]{};
  for (int first = 0; first < stride; first += Width) {
    const V ak = load<V>(a + first), bk = load<V>(b + first), ck = load<V>(c + first), sk = load<V>(s + first);
    const V u = ak * ck + bk * sk, w = bk * ck - ak * sk;
    for (int k = 0; k < Width; ++k) {
      const double *terms = taylor + 2 * lane_count * (first + k);
      for (int part = 0; part < parts; ++part) {
        even[part] += u[k] * load<V>(terms + part * Width);
        odd[part] += w[k] * load<V>(terms + lane_count + part * Width);
      }
    }
  }
  for (int part = 0; part < parts; ++part) {
    store(even[part], out.even + part * Width);
    store(odd[part], out.odd + part * Width);
  }
}

template <int Width> inline void bounds_parts(int stride, const double *a, const double *b, double *out) {
  using V = typename Vector<Width>::Real;
  V sum[4]{}, k{};
  for (int i = 0; i < Width; ++i) k[i] = i;
  for (int first = 0; first < stride; first += Width, k += Width) {
    const V ak = load<V>(a + first), bk = load<V>(b + first), square = ak * ak + bk * bk;
    V term;
    for (int i = 0; i < Width; ++i) term[i] = std::sqrt(square[i]);
    if (first == 0) term[0] = 0; // the mean
    for (int order = 0; order < 4; ++order) sum[order] += term, term *= k;
  }
  for (int order = 0; order < 4; ++order) out[order] = sum_of(sum[order]);
}

DOVETAIL_WIDE_PARTS(sum_waves,
                    (int harmonics, int ends, const double *table, const double *coefficients, double *value,
                     double *slope),
                    (harmonics, ends, table, coefficients, value, slope))
DOVETAIL_WIDE_PARTS(sum_terms,
                    (int stride, const double *a, const double *b, const double *c, const double *s,
                     const double *taylor, CellPolynomial &out),
                    (stride, a, b, c, s, taylor, out))
DOVETAIL_WIDE_PARTS(bounds, (int stride, const double *a, const double *b, double *out), (stride, a, b, out))

} // namespace

void Instant::set(double angle, int count) { set(angle, std::cos(angle), std::sin(angle), count); }

void Instant::set(double angle, double cosine_1, double sine_1, int count) {
  theta = angle;
  cosine.resize(padded(count)), sine.resize(padded(count));
  powers(cosine_1, sine_1, count, cosine.data(), sine.data());
}

// exp(i theta) from the one in the middle of the cell, not more than 0.05 away: series instead of the library's.
void Grid::find(long cell, double t, int count, Instant &instant) const {
  const double turn = t * width / 2, x = turn * turn;
  const double c = 1 - x / 2 * (1 - x / 12 * (1 - x / 30 * (1 - x / 56)));
  const double s = turn * (1 - x / 6 * (1 - x / 20 * (1 - x / 42)));
  const double *middle = &middles_[2 * (cell % cells) * stride_ + 1];
  instant.set((cell + 0.5) * width + turn, middle[0] * c - middle[stride_] * s, middle[stride_] * c + middle[0] * s,
              count);
}

Grid::Grid(int harmonics)
    : cells(std::max(64, 8 * harmonics)), ends(padded(cells + 1)), width(2 * M_PI / cells), harmonics_(harmonics),
      stride_(padded(harmonics + 1)), ends_(2 * harmonics * ends), middles_(2 * cells * stride_),
      taylor_(2 * lane_count * stride_) {
  const auto angle = [&](long k, long half_cells) { return M_PI * (k * half_cells % (2 * cells)) / cells; };
  for (int k = 1; k <= harmonics; ++k)
    for (int j = 0; j < ends; ++j) {
      ends_[2 * (k - 1) * ends + j] = std::cos(angle(k, 2 * j));
      ends_[(2 * k - 1) * ends + j] = std::sin(angle(k, 2 * j));
    }
  for (int j = 0; j < cells; ++j)
    for (int k = 0; k <= harmonics; ++k) {
      middles_[2 * j * stride_ + k] = std::cos(angle(k, 2 * j + 1));
      middles_[(2 * j + 1) * stride_ + k] = std::sin(angle(k, 2 * j + 1));
    }
  for (int k = 0; k <= harmonics; ++k) {
    double term = 1; // (k half)^q / q!, signs + + - - of cosine and sine
    for (int q = 0; q < 2 * lane_count; term *= k * width / 2 / ++q)
      taylor_[2 * lane_count * k + (q % 2) * lane_count + q / 2] = q / 2 % 2 ? -term : term;
  }
}

void Grid::sample(const double *coefficients, double *value, double *slope) const {
  sum_waves(harmonics_, ends, &ends_[0], coefficients, value, slope);
}

CellPolynomial Grid::expand(const Trigonometric &f, int cell) const {
  CellPolynomial out;
  const double *c = &middles_[2 * cell * stride_];
  sum_terms(stride_, &f.cosine_[0], &f.sine_[0], c, c + stride_, &taylor_[0], out);
  return out;
}

Trigonometric::Trigonometric(int harmonics)
    : harmonics_(harmonics), cosine_(padded(harmonics + 1)), sine_(cosine_.size()) {}

void Trigonometric::combine(double p, const double *x, double q, const double *y) {
  cosine_[0] = (p * x[0] + q * y[0]) / 2;
  for (int k = 1; k <= harmonics_; ++k) {
    cosine_[k] = p * x[cosine(k)] + q * y[cosine(k)];
    sine_[k] = p * x[sine(k)] + q * y[sine(k)];
  }
  bounds(static_cast<int>(cosine_.size()), &cosine_[0], &sine_[0], bound_.data());
}

double Trigonometric::at(const Instant &instant) const {
  double sum = 0;
  for (int k = 0; k <= harmonics_; ++k) sum += cosine_[k] * instant.cosine[k] + sine_[k] * instant.sine[k];
  return sum;
}

double Trigonometric::slope_at(const Instant &instant) const {
  double sum = 0;
  for (int k = 1; k <= harmonics_; ++k) sum += k * (sine_[k] * instant.cosine[k] - cosine_[k] * instant.sine[k]);
  return sum;
}

} // namespace dovetail
