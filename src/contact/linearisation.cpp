#include "contact/linearisation.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "contact/fourier.hpp"
#include "contact/wide.hpp"

namespace dovetail {
namespace {

// The arrays of Stretches below, from their places at m = 0.
DOVETAIL_WIDE void spread(int harmonics, double factor, const double *__restrict c, const double *__restrict s,
                          double *__restrict along, double *__restrict across) {
  for (int m = 0; m <= 2 * harmonics; ++m) {
    along[2 * m] = factor * c[m], along[2 * m + 1] = factor * s[m];
    across[2 * m] = factor * s[m], across[2 * m + 1] = -factor * c[m];
  }
  for (int m = 1; m <= harmonics; ++m) {
    along[-2 * m] = factor * c[m], along[1 - 2 * m] = -factor * s[m];
    across[-2 * m] = -factor * s[m], across[1 - 2 * m] = -factor * c[m];
  }
}

// Means of a mask for m = -H .. 2H as pairs, times a factor. With
//   along  = (cos m, sin m),   across = (sin m, -cos m)   at m,
// the cosine row k of the gram is along(l - k) + along(l + k) for l = 1 .. H in turn, the sine row
// across(l + k) - across(l - k): sums of two stretches of memory. One place before them the sum is zero.
class Stretches {
public:
  Stretches(const MaskMeans &mask, int harmonics, double factor, std::vector<double> &room) : harmonics_(harmonics) {
    const int length = 2 * (3 * harmonics + 1);
    room.resize(2 * (length + at_a_time * lane_count)); // whole vectors may be read beyond the ends
    double *along = room.data() + 2 * harmonics, *across = along + length + at_a_time * lane_count;
    spread(harmonics, factor, mask.cosine.data(), mask.sine.data(), along, across);
    along_ = along, across_ = across;
  }

  int size() const { return coefficient_count(harmonics_); }
  // Row i of the gram as first + sign * second, columns 1 .. 2H, and its column 0.
  struct Row {
    const double *first, *second;
    double sign, mean;
  };
  Row row(int i) const {
    const int k = (i + 1) / 2;
    if (i == 0 || i % 2) return {along_ + 2 * (1 - k), along_ + 2 * (1 + k), 1, along_[2 * k]};
    return {across_ + 2 * (1 + k), across_ + 2 * (1 - k), -1, across_[2 * k]};
  }

private:
  int harmonics_;
  const double *along_, *across_; // at m = 0
};

thread_local std::vector<double> room, more_room;

// block = gram + sum over `runs` of share * by, row by row in whole vectors; the last one reaches back over the one
// before. The stretches hold zero for the first column: it gets its mean afterwards.
template <class V, int runs>
inline void write_rows(int n, const Stretches &gram, const double *const *shares, const double *const *bys,
                       double *block) {
  constexpr int width = sizeof(V) / sizeof(double);
  const double *by[runs + 1];
  for (int r = 0; r < runs; ++r) by[r] = bys[r];
  for (int i = 0; i < n; ++i, block += n) {
    for (int j = 0; j < n; j += lane_count) __builtin_prefetch(block + 6 * n + j, 1); // rows soon to be written
    const Stretches::Row row = gram.row(i);
    double share[runs + 1];
    for (int r = 0; r < runs; ++r) share[r] = shares[r][i];
    for (int j = 0; j < n; j += width) {
      const int at = std::min(j, n - width);
      V sum = load<V>(row.first + at - 1) + row.sign * load<V>(row.second + at - 1);
      for (int r = 0; r < runs; ++r) sum += share[r] * load<V>(by[r] + at);
      store(sum, block + at);
    }
    block[0] += row.mean;
  }
}

template <int Width>
inline void write_block_parts(int n, const Stretches &gram, const double *const *shares, const double *const *bys,
                              int runs, double *block) {
  using V = typename Vector<Width>::Real;
  const int at_once = std::min(runs, 4); // a number of runs known here stays in registers
  if (n < Width)
    write_rows<typename Vector<1>::Real, 0>(n, gram, shares, bys, block);
  else if (at_once == 0)
    write_rows<V, 0>(n, gram, shares, bys, block);
  else if (at_once == 1)
    write_rows<V, 1>(n, gram, shares, bys, block);
  else if (at_once == 2)
    write_rows<V, 2>(n, gram, shares, bys, block);
  else if (at_once == 3)
    write_rows<V, 3>(n, gram, shares, bys, block);
  else
    write_rows<V, 4>(n, gram, shares, bys, block);
  for (int r = n < Width ? 0 : at_once; r < runs; ++r)
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) block[i * n + j] += shares[r][i] * bys[r][j];
}

// out += gram v, column by column: with v halved at its mean, the gram is symmetric but for its first row.
template <int Width> inline void multiply_block_parts(int n, const Stretches &gram, const double *v, double *out) {
  using V = typename Vector<Width>::Real;
  const Stretches::Row top = gram.row(0);
  double sum = top.mean * v[0];
  for (int j = 1; j < n; ++j) sum += 2 * top.first[j - 1] * v[j];
  out[0] += sum;
  for (int at = 1; at < n; at += at_a_time * Width) {
    V sums[at_a_time]{};
    for (int i = 0; i < n; ++i) {
      const Stretches::Row row = gram.row(i);
      const double factor = i == 0 ? v[0] / 2 : v[i], signed_factor = row.sign * factor;
      const double *first = row.first + at - 1, *second = row.second + at - 1;
      for (int q = 0; q < at_a_time; ++q)
        sums[q] += factor * load<V>(first + q * Width) + signed_factor * load<V>(second + q * Width);
    }
    for (int q = 0; q < at_a_time * Width && at + q < n; ++q) out[at + q] += sums[q / Width][q % Width];
  }
}

DOVETAIL_WIDE_PARTS(write_block,
                    (int n, const Stretches &gram, const double *const *shares, const double *const *bys, int runs,
                     double *block),
                    (n, gram, shares, bys, runs, block))
DOVETAIL_WIDE_PARTS(multiply_block, (int n, const Stretches &gram, const double *v, double *out), (n, gram, v, out))

void write_spring(int n, double k, double *block) {
  std::fill_n(block, n * n, 0.0);
  for (int i = 0; i < n; ++i) block[i * (n + 1)] = k;
}

void write_normal(int n, const MaskMeans &closed, double kn, double *block) {
  if (closed.whole()) return write_spring(n, kn, block);
  write_block(n, Stretches(closed, n / 2, kn, room), nullptr, nullptr, 0, block);
}

} // namespace

const std::vector<BlockPlace> &block_places(Law law, bool transposed) {
  using Places = std::vector<BlockPlace>;
  static const Places coulomb{{0, 0}, {0, 2}, {1, 1}, {1, 2}, {2, 2}},
      cone{{0, 0}, {0, 1}, {0, 2}, {1, 0}, {1, 1}, {1, 2}, {2, 2}}, normal{{2, 2}};
  const auto turned = [](Places places) {
    for (BlockPlace &place : places) std::swap(place.row, place.column);
    return places;
  };
  static const Places coulomb_turned = turned(coulomb), cone_turned = turned(cone);
  if (law == Law::coulomb) return transposed ? coulomb_turned : coulomb;
  if (law == Law::cone) return transposed ? cone_turned : cone;
  return normal;
}

void MaskMeans::reset(int harmonics) {
  cosine.assign(coefficient_count(harmonics), 0.0);
  sine.assign(coefficient_count(harmonics), 0.0);
}

void MaskMeans::set_whole() {
  reset(static_cast<int>(cosine.size()) / 2);
  cosine[0] = 1;
}

double MaskMeans::gram(int row, int column) const {
  const int k = (row + 1) / 2, l = (column + 1) / 2;
  const bool k_cosine = row % 2 == 1, l_cosine = column % 2 == 1;
  const auto odd = [&](int m) { return m < 0 ? -sine[-m] : sine[m]; };
  if (row == 0) return column == 0 ? cosine[0] : 2 * (l_cosine ? cosine : sine)[l];
  if (column == 0) return (k_cosine ? cosine : sine)[k];
  if (k_cosine == l_cosine) return cosine[std::abs(k - l)] + (k_cosine ? 1 : -1) * cosine[k + l];
  return odd(k + l) + (l_cosine ? odd(k - l) : odd(l - k));
}

void MaskMeans::add_gram_times(double factor, const double *v, double *out) const {
  if (whole()) {
    for (std::size_t i = 0; i < cosine.size(); ++i) out[i] += factor * v[i];
    return;
  }
  const Stretches gram(*this, static_cast<int>(cosine.size()) / 2, factor, room);
  multiply_block(gram.size(), gram, v, out);
}

void Linearisation::reset(int harmonics) {
  harmonics_ = harmonics;
  count_ = 0, spans = 1;
  springs_only = false;
  dense.clear();
  for (MaskMeans *mask : {&closed, &stick[0], &stick[1], &slip[0], &slip[1]}) mask->reset(harmonics);
}

Linearisation::Run &Linearisation::add_run(int direction) {
  if (count_ == runs_.size()) runs_.emplace_back();
  Run &run = runs_[count_++];
  run.direction = direction;
  for (auto *row : {&run.share, &run.by_t, &run.by_n}) row->resize(coefficient_count(harmonics_));
  return run;
}

void Linearisation::write(const ContactPoint &point, double *blocks) const {
  if (!dense.empty()) {
    std::copy(dense.begin(), dense.end(), blocks);
    return;
  }
  const int n = coefficient_count(harmonics_), size = n * n;
  if (point.law == Law::bilateral || point.law == Law::unilateral) {
    if (point.law == Law::bilateral || springs_only) return write_spring(n, point.kn, blocks);
    return write_normal(n, closed, point.kn, blocks);
  }
  if (springs_only) {
    for (int d = 0; d < 2; ++d) {
      write_spring(n, point.kt[d], blocks + 2 * d * size);
      std::fill_n(blocks + (2 * d + 1) * size, size, 0.0);
    }
    return write_spring(n, point.kn, blocks + 4 * size);
  }
  thread_local std::vector<const double *> shares, by_t, by_n;
  for (int d = 0; d < 2; ++d) {
    shares.clear(), by_t.clear(), by_n.clear();
    for (const Run &run : *this)
      if (run.direction == d)
        shares.push_back(run.share.data()), by_t.push_back(run.by_t.data()), by_n.push_back(run.by_n.data());
    const int runs = static_cast<int>(shares.size());
    const Stretches sticking(stick[d], harmonics_, point.kt[d], room);
    const Stretches slipping(slip[d], harmonics_, point.mu[d] * point.kn, more_room);
    write_block(n, sticking, shares.data(), by_t.data(), runs, blocks + 2 * d * size);
    write_block(n, slipping, shares.data(), by_n.data(), runs, blocks + (2 * d + 1) * size);
  }
  write_normal(n, closed, point.kn, blocks + 4 * size);
}

void Linearisation::write(const ContactPoint &point, const int *which, int count, double *blocks) const {
  const std::size_t size = static_cast<std::size_t>(count) * count;
  const bool stuck = springs_only || point.law == Law::bilateral;
  for (const BlockPlace place : block_places(point.law)) {
    const int d = place.row;
    const bool slips = place.column != d;
    if (stuck) {
      std::fill_n(blocks, size, 0.0);
      for (int i = 0; i < count && !slips; ++i) blocks[i * (count + 1)] = stuck_springs(point)[d];
    } else {
      const MaskMeans &mask = d == 2 ? closed : (slips ? slip : stick)[d];
      const double factor = d == 2 ? point.kn : slips ? point.mu[d] * point.kn : point.kt[d];
      for (int i = 0; i < count; ++i)
        for (int j = 0; j < count; ++j) blocks[i * count + j] = factor * mask.gram(which[i], which[j]);
      for (const Run &run : *this) {
        if (run.direction != d) continue;
        const std::vector<double> &by = slips ? run.by_n : run.by_t;
        for (int i = 0; i < count; ++i)
          for (int j = 0; j < count; ++j) blocks[i * count + j] += run.share[which[i]] * by[which[j]];
      }
    }
    blocks += size;
  }
}

std::array<double, 3> Linearisation::mean_stiffness(const ContactPoint &point) const {
  std::array<double, 3> stiffness = stuck_springs(point);
  if (springs_only || point.law == Law::bilateral) return stiffness;
  if (!dense.empty()) {
    const std::size_t size = static_cast<std::size_t>(coefficient_count(harmonics_)) * coefficient_count(harmonics_);
    const auto &places = block_places(point.law);
    for (std::size_t b = 0; b < places.size(); ++b)
      if (places[b].row == places[b].column) stiffness[places[b].row] = dense[b * size];
    return stiffness;
  }
  for (int d = 0; d < 2; ++d) stiffness[d] *= stick[d].cosine[0];
  for (const Run &run : *this) stiffness[run.direction] += run.share[0] * run.by_t[0];
  stiffness[2] *= closed.cosine[0];
  return stiffness;
}

void Linearisation::multiply(const ContactPoint &point, const double *v, double *out) const {
  const int n = coefficient_count(harmonics_);
  std::fill_n(out, 3 * n, 0.0);
  if (!dense.empty()) {
    const double *block = dense.data();
    for (const BlockPlace place : block_places(point.law))
      for (int i = 0; i < n; ++i, block += n)
        out[place.row * n + i] += std::inner_product(block, block + n, v + place.column * n, 0.0);
    return;
  }
  const bool friction = has_friction(point.law);
  if (springs_only || point.law == Law::bilateral) {
    for (int i = 0; i < n; ++i) {
      out[2 * n + i] = point.kn * v[2 * n + i];
      for (int d = 0; friction && d < 2; ++d) out[d * n + i] = point.kt[d] * v[d * n + i];
    }
    return;
  }
  closed.add_gram_times(point.kn, v + 2 * n, out + 2 * n);
  for (int d = 0; friction && d < 2; ++d) {
    stick[d].add_gram_times(point.kt[d], v + d * n, out + d * n);
    slip[d].add_gram_times(point.mu[d] * point.kn, v + 2 * n, out + d * n);
  }
  for (const Run &run : *this) {
    const double *v_t = v + run.direction * n, *v_n = v + 2 * n;
    const double change = std::inner_product(run.by_t.begin(), run.by_t.end(), v_t, 0.0) +
                          std::inner_product(run.by_n.begin(), run.by_n.end(), v_n, 0.0);
    for (int i = 0; i < n; ++i) out[run.direction * n + i] += change * run.share[i];
  }
}

} // namespace dovetail
