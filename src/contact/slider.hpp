#pragma once
// One slider over a stretch of time in which the contact is closed, without sampling.
//
// Seen from the slider, Coulomb's law (law.hpp) says: v = k_t w lies between k_t x - mu N and k_t x + mu N, rests
// there, and is pushed along where one of these edges runs into it. With an edge for each side s = +1, -1,
//   e_s = s k_t x - mu k_n p,                      p = x_n - x_n0 > 0,
// it slips (T = s mu N, v = s e_s) from where e_s rises above s v to where e_s stops rising. Where the contact opens
// and closes the two edges meet, and landing needs no rule of its own: there v = k_t x.
#include <cmath>

#include "contact/falling.hpp"

namespace dovetail {

/// The numbered instants of one evaluation. Number 0 is theta = 0, and the end of the period as well.
class Instants {
public:
  Instants(const Grid &grid, int count) : grid_(grid), list_(1) { list_[0].set_zero(count); }
  void clear() { used_ = 1; }
  int add(long cell, double t) {
    if (used_ == static_cast<int>(list_.size())) list_.emplace_back();
    grid_.find(cell, t, list_[used_]);
    return used_++;
  }
  const Instant &operator[](int number) const { return list_[number]; }

private:
  const Grid &grid_;
  int used_ = 1;
  std::vector<Instant> list_;
};

/// Time between two changes of state of a slider.
struct Stretch {
  double begin = 0, end = 0;
  int from = 0, to = 0; ///< numbers of these instants
  int side = 0;         ///< 0 sticks; +1 or -1 slips, T = side mu N
  double v = 0;         ///< sticks: T = k_t x - v
  int set_at = -1;      ///< sticks: number of the instant that set v, or negative: the memory w_p
  int set_by = 0;       ///< sticks: side of the slip that ended there, or 0: a landing
};

/// One that sticks, where and when does not matter yet.
inline Stretch sticking(double v, int set_at, int set_by) {
  Stretch s;
  s.v = v, s.set_at = set_at, s.set_by = set_by;
  return s;
}

class Slider {
public:
  Slider(int harmonics, const Grid &grid, Instants &instants);

  /// Edges from k_t, mu k_n [N/m] and coefficients of x and p; their values x, p on the grid are wanted by march()
  /// only, and given by on_grid(): (cells + 1) each, with slopes.
  void set(double kt, double mu_kn, const double *x, const double *p);
  void on_grid(const double *x, const double *x_slope, const double *p, const double *p_slope);

  /// True if bounds alone show that the slider rests at v for ever.
  bool rests(double v) const;

  double size() const { return edge(1).f.bound(0) + std::abs(edge(1).f.mean()); } ///< of the forces at work
  double tiny(double v) const; ///< what is round-off of the edges or of v

  /// Marches over begin <= theta <= end, instants `from` and `to`, and appends the stretches to `out`. `state`: side, v
  /// and what set it at the beginning; its times are not used. `before`: stretches of a march over the same time from
  /// another state; as soon as the two slip alike, the rest is copied from it. Returns the last stretch.
  Stretch march(Stretch state, double begin, int from, double end, int to, std::vector<Stretch> &out,
                const std::vector<Stretch> *before = nullptr);

  /// v that slip on this side leaves behind at an instant.
  double left_by(int side, int instant) const { return side * edge(side).f.at(instants_[instant]); }
  /// Where slip on side +1 ends at the highest place of its edge, if the slider is pushed both ways in every round
  /// wherever it began; its number, or -1. It may be the wrong one of two that are almost as high.
  int turning_point();
  double landed(int instant) const;        ///< v = k_t x at a landing
  double landing_slope(int instant) const; ///< k_t x_t' / x_n' there: by it v falls when the landing comes early
  /// Side on which an edge has overrun a slider at v, at theta = 0; 0 if none.
  int overrun(double v) const;

private:
  struct Edge {
    Trigonometric f;
    std::vector<double> value, slope;    // (cells + 1) at the ends of the cells
    std::vector<double> highest, lowest; // (cells) bounds of the value from above, of the slope from below
    CellPolynomial expanded;             // f in the cell of this number
    int in_cell = -1;
  };
  const Edge &edge(int side) const { return edges_[side < 0]; }
  const CellPolynomial &expand(int side, int cell);
  long skip_quiet(const Stretch &state, long cell, long last) const;
  double next_event(const Stretch &state, int cell, bool whole, double from, double to, int &side);
  void settle(Stretch &state, int now) const;

  const Grid &grid_;
  Instants &instants_;
  double kt_ = 0, mu_kn_ = 0;
  std::vector<Edge> edges_; // of side +1, of side -1
};

} // namespace dovetail
