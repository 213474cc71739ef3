#include "contact/slider.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "contact/wide.hpp"

namespace dovetail {
namespace {

constexpr int most_events = 16; // of a slider in one cell of the grid; more are round-off
constexpr double hair = 1e-13;  // of half a cell

// An edge at the ends of the cells. In a cell no value is above `highest` - from either end at most half a cell along
// the tangent, and `curved` above it - and no slope below `lowest`.
template <int Width>
inline void lay_out_parts(int ends, int cells, double kt, double mu_kn, const double *x, const double *x_slope,
                          const double *p, const double *p_slope, double half, double curved, double slope_curved,
                          double *value, double *slope, double *highest, double *lowest) {
  using V = typename Vector<Width>::Real;
  for (int j = 0; j < ends; j += Width) {
    store<V>(kt * load<V>(x + j) - mu_kn * load<V>(p + j), value + j);
    store<V>(kt * load<V>(x_slope + j) - mu_kn * load<V>(p_slope + j), slope + j);
  }
  const auto above = [](const V &a, const V &b) -> V { return a > b ? a : b; };
  for (int j = 0; j < cells; j += Width) {
    const V a = load<V>(value + j), b = load<V>(value + j + 1), da = load<V>(slope + j), db = load<V>(slope + j + 1);
    const V left = a + half * da + curved, right = b - half * db + curved;
    store<V>(above(above(a, b), above(left, right)), highest + j);
    store<V>((da < db ? da : db) - slope_curved, lowest + j);
  }
}

// The largest of the first `count` values, a whole number of vectors.
template <int Width> inline void find_highest_parts(int count, const double *values, double &highest) {
  using V = typename Vector<Width>::Real;
  V most = load<V>(values);
  for (int j = Width; j < count; j += Width) {
    const V here = load<V>(values + j);
    most = here > most ? here : most;
  }
  highest = most[0];
  for (int i = 1; i < Width; ++i) highest = std::max(highest, most[i]);
}

DOVETAIL_WIDE_PARTS(find_highest, (int count, const double *values, double &highest), (count, values, highest))

double highest_of(int count, const double *values) {
  double highest;
  find_highest(count, values, highest);
  return highest;
}

DOVETAIL_WIDE_PARTS(lay_out,
                    (int ends, int cells, double kt, double mu_kn, const double *x, const double *x_slope,
                     const double *p, const double *p_slope, double half, double curved, double slope_curved,
                     double *value, double *slope, double *highest, double *lowest),
                    (ends, cells, kt, mu_kn, x, x_slope, p, p_slope, half, curved, slope_curved, value, slope, highest,
                     lowest))

} // namespace

Slider::Slider(int harmonics, const Grid &grid, Instants &instants) : grid_(grid), instants_(instants) {
  const std::vector<double> ends(grid.ends + 8);
  edges_.assign(2, Edge{Trigonometric(harmonics), ends, ends, ends, ends, {}, -1});
}

void Slider::set(double kt, double mu_kn, const double *x, const double *p) {
  for (const int side : {1, -1}) edges_[side < 0].f.combine(side * kt, x, -mu_kn, p), edges_[side < 0].in_cell = -1;
  kt_ = kt, mu_kn_ = mu_kn;
}

void Slider::on_grid(const double *x, const double *x_slope, const double *p, const double *p_slope) {
  const double h2 = grid_.width * grid_.width / 8;
  for (const int side : {1, -1}) {
    Edge &e = edges_[side < 0];
    lay_out(grid_.ends, grid_.cells, side * kt_, mu_kn_, x, x_slope, p, p_slope, grid_.width / 2, h2 * e.f.bound(2),
            h2 * e.f.bound(3), e.value.data(), e.slope.data(), e.highest.data(), e.lowest.data());
  }
}

double Slider::tiny(double v) const { return 8 * std::numeric_limits<double>::epsilon() * (size() + std::abs(v)); }

bool Slider::rests(double v) const {
  for (const int side : {1, -1})
    if (edge(side).f.mean() + edge(side).f.bound(0) > side * v + tiny(v)) return false;
  return true;
}

int Slider::overrun(double v) const {
  for (const int side : {1, -1})
    if (edge(side).f.at(instants_[0]) > side * v + tiny(v)) return side;
  return 0;
}

int Slider::turning_point() {
  const std::vector<double> &forth = edge(1).value;
  const double highest = highest_of(grid_.cells, forth.data()), other = highest_of(grid_.cells, edge(-1).value.data());
  if (highest + other <= 0) return -1; // there is a place between the edges that neither reaches
  const int top = static_cast<int>(std::find(forth.begin(), forth.end(), highest) - forth.begin());
  const int cell = edge(1).slope[top] > 0 ? top : (top + grid_.cells - 1) % grid_.cells;
  const Trigonometric &f = edge(1).f;
  const double t = Falling::slope(expand(1, cell), 1, f.bound(1) + f.bound(2)).first_in_cell();
  return t < Falling::none ? instants_.add(cell, t) : -1;
}

double Slider::landed(int instant) const {
  return (edge(1).f.at(instants_[instant]) - edge(-1).f.at(instants_[instant])) / 2;
}

double Slider::landing_slope(int instant) const {
  const double forward = edge(1).f.slope_at(instants_[instant]), backward = edge(-1).f.slope_at(instants_[instant]);
  const double closing = -(forward + backward); // 2 mu k_n x_n'
  return closing > 0 ? mu_kn_ * (forward - backward) / closing : 0;
}

const CellPolynomial &Slider::expand(int side, int cell) {
  Edge &e = edges_[side < 0];
  if (e.in_cell != cell) grid_.expand(e.f, cell, e.expanded), e.in_cell = cell;
  return e.expanded;
}

// The first cell, not beyond `last`, in which the state may change.
long Slider::skip_quiet(const Stretch &state, long cell, long last) const {
  const double *up = edge(1).highest.data(), *down = edge(-1).highest.data(), v = state.v;
  const double *slope = state.side != 0 ? edge(state.side).lowest.data() : nullptr;
  while (cell < last) {
    const long base = cell / grid_.cells * grid_.cells, to = std::min(last - base, static_cast<long>(grid_.cells));
    long j = cell - base;
    if (slope)
      while (j < to && slope[j] > 0) ++j;
    else
      while (j < to && up[j] < v && down[j] < -v) ++j;
    cell = base + j;
    if (j < to) break;
  }
  return cell;
}

// The first change of state in a cell from t = from to t = to, and the side that slips then; none if there is none.
// `whole`: that is all of the cell, and nothing happens at its very beginning.
double Slider::next_event(const Stretch &state, int cell, bool whole, double from, double to, int &side) {
  const auto first = [&](const Falling &g) { return whole ? g.first_in_cell() : g.first(from, to); };
  if (state.side != 0) {
    side = 0;
    if (edge(state.side).lowest[cell] > 0) return Falling::none;
    const Trigonometric &f = edge(state.side).f;
    return first(Falling::slope(expand(state.side, cell), 1, f.bound(1) + f.bound(2)));
  }
  double earliest = Falling::none;
  for (const int s : {1, -1}) {
    const Edge &e = edge(s);
    if (e.highest[cell] < s * state.v) continue;
    const double size = std::abs(e.f.mean()) + e.f.bound(0) + e.f.bound(1);
    const double t = first(Falling(expand(s, cell), -1, s * state.v, size));
    if (t < earliest) earliest = t, side = s;
  }
  return earliest;
}

// The state that the law leaves at an instant, where round-off made it change without end before.
void Slider::settle(Stretch &state, int now) const {
  if (state.side != 0) {
    state.v = left_by(state.side, now), state.set_at = now, state.set_by = state.side, state.side = 0;
    return;
  }
  for (const int side : {1, -1})
    if (edge(side).f.at(instants_[now]) > side * state.v)
      state.v = left_by(side, now), state.set_at = now, state.set_by = side;
}

Stretch Slider::march(Stretch state, double begin, int from, double end, int to, std::vector<Stretch> &out,
                      const std::vector<Stretch> *before) {
  state.begin = begin, state.from = from;
  const auto close = [&](double theta, int instant) {
    state.end = theta, state.to = instant;
    if (theta > state.begin) out.push_back(state);
    state.begin = theta, state.from = instant;
  };
  long cell = static_cast<long>(std::floor(begin / grid_.width));
  double t = (begin - grid_.middle(cell)) / (grid_.width / 2); // in the cell
  int events = 0;
  const long last_whole = static_cast<long>(std::floor(end / grid_.width)) - 1;
  for (bool whole = false;;) {
    if (whole) cell = skip_quiet(state, cell, last_whole);
    const int place = static_cast<int>(cell % grid_.cells);
    const double left = (end - grid_.middle(cell)) / (grid_.width / 2), last = left < 1 - hair ? left : 1;
    whole = whole && last == 1;
    int side = 0;
    const bool passes = last - t < hair;
    t = passes ? Falling::none : next_event(state, place, whole, t, last, side);
    if (last < 1 && t < Falling::none && last - t < hair) t = Falling::none; // at lift-off, where both edges meet
    if (t == Falling::none || ++events > most_events) {
      if (t < Falling::none) {
        const int now = instants_.add(cell, last);
        close(instants_[now].theta, now);
        settle(state, now);
      }
      if (left <= 1 + hair) break;
      t = -1, whole = true, events = 0, ++cell;
      continue;
    }
    const int now = instants_.add(cell, t);
    const double event = instants_[now].theta;
    close(event, now);
    if (state.side != 0) state.v = left_by(state.side, now), state.set_at = now, state.set_by = state.side;
    state.side = side;
    whole = false;
    if (!before || side == 0) continue;
    const auto same = std::find_if(before->begin(), before->end(), [&](const Stretch &b) {
      return b.side == side && b.begin <= event && event < b.end;
    });
    if (same == before->end()) continue;
    close(same->end, same->to);
    out.insert(out.end(), same + 1, before->end());
    return out.back();
  }
  close(end, to);
  return state;
}

} // namespace dovetail
