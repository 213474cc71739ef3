#include "contact/trigonometric.hpp"

#include <algorithm>
#include <cmath>

#include "contact/fourier.hpp"
#include "contact/wide.hpp"

namespace dovetail {
namespace {

constexpr int many = 48; // harmonics, from which on transforms take less time than sums

// At least `least`, of small factors.
int quick_to_transform(int least) {
  for (int n = least;; ++n) {
    int left = n;
    for (const int factor : {2, 3, 5})
      while (left % factor == 0) left /= factor;
    if (left == 1) return n;
  }
}

constexpr int padded(int count, int to = lane_count) { return (count + to - 1) / to * to; }

// cos m theta, sin m theta from those in the middle of a cell, `turn` away: series in m turn, which is at most pi / 4.
template <int Width>
inline void turn_parts(int count, double turn, const double *middle_c, const double *middle_s, double *c, double *s) {
  using V = typename Vector<Width>::Real;
  V m{};
  for (int i = 0; i < Width; ++i) m[i] = i;
  for (int first = 0; first < count; first += Width, m += Width) {
    const V angle = m * turn, x = angle * angle;
    V cosine{}, sine{};
    for (int q = 16; q > 0; q -= 2) { // Horner: 1 - x / (1 2) (1 - x / (3 4) (...
      cosine = 1 - x * (1.0 / (q * (q - 1))) * (q == 16 ? V{} + 1 : cosine);
      sine = 1 - x * (1.0 / (q * (q + 1))) * (q == 16 ? V{} + 1 : sine);
    }
    sine *= angle;
    const V mc = load<V>(middle_c + first), ms = load<V>(middle_s + first);
    store<V>(mc * cosine - ms * sine, c + first), store<V>(ms * cosine + mc * sine, s + first);
  }
}

// From one end of a cell to before another, some vectors of them at a time; tables and values have room for whole ones.
template <int Width>
inline void sum_waves_parts(int harmonics, int ends, int from, int to, const double *table, const double *coefficients,
                            double *value, double *slope) {
  using V = typename Vector<Width>::Real;
  for (int j = from; j < to; j += at_a_time * Width) {
    V f[at_a_time], f1[at_a_time]{};
    for (V &sum : f) sum = V{} + coefficients[0] / 2;
    for (int k = 1; k <= harmonics; ++k) {
      const double a = coefficients[cosine(k)], b = coefficients[sine(k)], ka = k * a, kb = k * b;
      const double *c = table + 2 * (k - 1) * ends + j, *s = c + ends;
      for (int i = 0; i < at_a_time; ++i) {
        const V ci = load<V>(c + i * Width), si = load<V>(s + i * Width);
        f[i] += a * ci + b * si;
        f1[i] += kb * ci - ka * si;
      }
    }
    for (int i = 0; i < at_a_time; ++i) store(f[i], value + j + i * Width), store(f1[i], slope + j + i * Width);
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

DOVETAIL_WIDE_PARTS(turn,
                    (int count, double turn, const double *middle_c, const double *middle_s, double *c, double *s),
                    (count, turn, middle_c, middle_s, c, s))
DOVETAIL_WIDE_PARTS(sum_waves,
                    (int harmonics, int ends, int from, int to, const double *table, const double *coefficients,
                     double *value, double *slope),
                    (harmonics, ends, from, to, table, coefficients, value, slope))
DOVETAIL_WIDE_PARTS(sum_terms,
                    (int stride, const double *a, const double *b, const double *c, const double *s,
                     const double *taylor, CellPolynomial &out),
                    (stride, a, b, c, s, taylor, out))
DOVETAIL_WIDE_PARTS(bounds, (int stride, const double *a, const double *b, double *out), (stride, a, b, out))

} // namespace

void Instant::set_zero(int count) {
  theta = 0;
  cosine.assign(padded(count), 1.0), sine.assign(padded(count), 0.0);
}

void Grid::find(long cell, double t, Instant &instant) const {
  const double change = t * width / 2, *middle = middles_.values() + 2 * (cell % cells) * powers_;
  instant.theta = (cell + 0.5) * width + change;
  instant.cosine.resize(powers_), instant.sine.resize(powers_);
  turn(powers_, change, middle, middle + powers_, instant.cosine.data(), instant.sine.data());
}

Grid::Grid(int harmonics)
    : cells(harmonics < many ? std::max(64, 8 * harmonics) : quick_to_transform(8 * harmonics)),
      ends(padded(cells + 1, at_a_time * lane_count)), width(2 * M_PI / cells), harmonics_(harmonics),
      stride_(padded(harmonics + 1)), powers_(padded(2 * harmonics + 1)),
      transform_(harmonics < many ? nullptr : std::make_unique<WaveTransform>(harmonics, cells)),
      ends_(transform_ ? 0 : 2 * harmonics * ends / lane_count), middles_(2 * cells * powers_ / lane_count),
      taylor_(2 * stride_) {
  double *at_ends = ends_.values(), *at_middles = middles_.values(), *terms = taylor_.values();
  std::vector<std::array<double, 2>> turns; // cosine and sine, half cells apart
  for (int i = 0; i < 2 * cells; ++i) turns.push_back({std::cos(M_PI * i / cells), std::sin(M_PI * i / cells)});
  const auto turned = [&](long k, long half_cells) { return turns[k * half_cells % (2 * cells)]; };
  for (int k = 1; k <= harmonics && !transform_; ++k)
    for (int j = 0; j < ends; ++j) {
      const auto [c, s] = turned(k, 2 * j);
      at_ends[2 * (k - 1) * ends + j] = c, at_ends[(2 * k - 1) * ends + j] = s;
    }
  for (int j = 0; j < cells; ++j)
    for (int m = 0; m <= 2 * harmonics; ++m) {
      const auto [c, s] = turned(m, 2 * j + 1);
      at_middles[2 * j * powers_ + m] = c, at_middles[(2 * j + 1) * powers_ + m] = s;
    }
  for (int k = 0; k <= harmonics; ++k) {
    double term = 1; // (k half)^q / q!, signs + + - - of cosine and sine
    for (int q = 0; q < 2 * lane_count; term *= k * width / 2 / ++q)
      terms[2 * lane_count * k + (q % 2) * lane_count + q / 2] = q / 2 % 2 ? -term : term;
  }
}

void Grid::sample(const double *coefficients, int first, int last, double *value, double *slope) const {
  if (transform_) {
    transform_->sample(coefficients, value, slope);
    std::copy_n(value, ends - cells, value + cells), std::copy_n(slope, ends - cells, slope + cells);
    return;
  }
  constexpr int together = at_a_time * lane_count;
  const int from = std::max(first, 0) / together * together, to = std::min(last + 2, ends);
  sum_waves(harmonics_, ends, from, to, ends_.values(), coefficients, value, slope);
}

void Grid::expand(const Trigonometric &f, int cell, CellPolynomial &out) const {
  const double *c = middles_.values() + 2 * cell * powers_;
  sum_terms(stride_, f.cosine_.values(), f.sine_.values(), c, c + powers_, taylor_.values(), out);
}

Trigonometric::Trigonometric(int harmonics)
    : harmonics_(harmonics), cosine_(padded(harmonics + 1) / lane_count), sine_(cosine_.size()) {}

void Trigonometric::combine(double p, const double *x, double q, const double *y) {
  double *a = cosine_.values(), *b = sine_.values();
  a[0] = (p * x[0] + q * y[0]) / 2;
  for (int k = 1; k <= harmonics_; ++k) {
    a[k] = p * x[cosine(k)] + q * y[cosine(k)];
    b[k] = p * x[sine(k)] + q * y[sine(k)];
  }
  bounds(static_cast<int>(cosine_.size()) * lane_count, a, b, bound_.data());
}

double Trigonometric::at(const Instant &instant) const {
  const double *a = cosine_.values(), *b = sine_.values();
  double sum = 0;
  for (int k = 0; k <= harmonics_; ++k) sum += a[k] * instant.cosine[k] + b[k] * instant.sine[k];
  return sum;
}

double Trigonometric::slope_at(const Instant &instant) const {
  const double *a = cosine_.values(), *b = sine_.values();
  double sum = 0;
  for (int k = 1; k <= harmonics_; ++k) sum += k * (b[k] * instant.cosine[k] - a[k] * instant.sine[k]);
  return sum;
}

} // namespace dovetail
