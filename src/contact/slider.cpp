#include "contact/slider.hpp"

#include <algorithm>
#include <cmath>

#include "contact/wide.hpp"

namespace dovetail {
namespace {

constexpr int most_events = 16; // of a slider in one cell of the grid; more are round-off
constexpr double hair = 1e-13;  // of a cell

DOVETAIL_WIDE void lay_out(int cells, double kt, double mu_kn, const double *x, const double *x_slope, const double *p,
                           const double *p_slope, double above, double below, double *__restrict value,
                           double *__restrict slope, double *__restrict highest, double *__restrict lowest) {
  for (int j = 0; j <= cells; ++j) value[j] = kt * x[j] - mu_kn * p[j], slope[j] = kt * x_slope[j] - mu_kn * p_slope[j];
  for (int j = 0; j < cells; ++j) {
    highest[j] = std::max(value[j], value[j + 1]) + above;
    lowest[j] = std::min(slope[j], slope[j + 1]) - below;
  }
}

} // namespace

Slider::Slider(int harmonics, const Grid &grid, Instants &instants) : grid_(grid), instants_(instants) {
  const std::vector<double> ends(grid.ends), cells(grid.cells);
  edges_.assign(2, Edge{Trigonometric(harmonics), ends, ends, cells, cells, {}, -1});
}

void Slider::set(double kt, double mu_kn, const double *x, const double *p) {
  for (const int side : {1, -1}) edges_[side < 0].f.combine(side * kt, x, -mu_kn, p), edges_[side < 0].in_cell = -1;
  kt_ = kt, mu_kn_ = mu_kn;
}

void Slider::on_grid(const double *x, const double *x_slope, const double *p, const double *p_slope) {
  const double h2 = grid_.width * grid_.width / 8; // a function is at most h^2/8 max|f''| off its chord
  for (const int side : {1, -1}) {
    Edge &e = edges_[side < 0];
    lay_out(grid_.cells, side * kt_, mu_kn_, x, x_slope, p, p_slope, h2 * e.f.bound(2), h2 * e.f.bound(3),
            e.value.data(), e.slope.data(), e.highest.data(), e.lowest.data());
  }
}

bool Slider::rests(double v) const {
  for (const int side : {1, -1})
    if (edge(side).f.mean() + edge(side).f.bound(0) > side * v) return false;
  return true;
}

int Slider::overrun(double v) const {
  for (const int side : {1, -1})
    if (edge(side).f.at(instants_[0]) > side * v) return side;
  return 0;
}

int Slider::turning_point() {
  const std::vector<double> &forth = edge(1).value, &back = edge(-1).value;
  int top = 0;
  double other = back[0];
  for (int j = 1; j < grid_.cells; ++j) {
    top = forth[j] > forth[top] ? j : top;
    other = std::max(other, back[j]);
  }
  if (forth[top] + other <= 0) return -1; // there is a place between the edges that neither reaches
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
  if (e.in_cell != cell) e.expanded = grid_.expand(e.f, cell), e.in_cell = cell;
  return e.expanded;
}

bool Slider::quiet(const Stretch &state, int cell) const {
  if (state.side != 0) return edge(state.side).lowest[cell] > 0;
  return edge(1).highest[cell] < state.v && edge(-1).highest[cell] < -state.v;
}

// The first change of state in a cell from t = from to t = to, and the side that slips then; none if there is none.
// `whole`: that is all of the cell, and nothing happens at its very beginning.
double Slider::next_event(const Stretch &state, int cell, bool whole, double from, double to, int &side) {
  const auto first = [&](const Falling &g) { return whole ? g.first_in_cell() : g.first(from, to); };
  if (state.side != 0) {
    side = 0;
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
    int place = static_cast<int>(cell % grid_.cells);
    for (; whole && cell < last_whole && quiet(state, place); ++cell)
      if (++place == grid_.cells) place = 0;
    const double left = (end - grid_.middle(cell)) / (grid_.width / 2), last = left < 1 - hair ? left : 1;
    whole = whole && last == 1;
    int side = 0;
    const bool passes = (whole && quiet(state, place)) || last - t < hair;
    t = passes ? Falling::none : next_event(state, place, whole, t, last, side);
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
