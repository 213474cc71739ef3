#pragma once
// Laws with independent directions over one period, without sampling: instants of every change of state, and integrals
// in closed form between them (Petrov & Ewins 2003).
#include "contact/activity.hpp"
#include "contact/graze.hpp"
#include "contact/law.hpp"
#include "contact/linearisation.hpp"
#include "contact/slider.hpp"

namespace dovetail {

/// Laws coulomb and unilateral for one point. Holds scratch memory: one object per thread.
class ExactLaw {
public:
  explicit ExactLaw(int harmonics);
  ExactLaw(const ExactLaw &) = delete;

  /// X, G (3, 2H+1), the derivative into `linear`. See ContactForces::evaluate. A motion that is not finite gets no
  /// force.
  void evaluate(const ContactPoint &point, const Standstill &standstill, const double *X, double *G, Activity &activity,
                Linearisation &linear);

  struct Span { ///< closed from begin to end, numbers of these instants; end may lie in the next period
    double begin, end;
    int from, to;
  };
  /// Of the motion evaluated last, for those who follow what becomes of small changes: when the point is closed, and
  /// what a direction with friction does in these spans, in the order of time. Both are empty where bounds alone showed
  /// that the point is always open or always stuck on w_p.
  const std::vector<Span> &spans() const { return spans_; }
  const std::vector<Stretch> &run(int direction) const { return run_[direction]; }
  double instant(int number) const { return instants_[number].theta; }
  /// Of that motion, X, all places where a slider could begin to slip; grazes.cpp.
  std::vector<Graze> grazes(const ContactPoint &point, const Standstill &standstill, const double *X) const;
  /// k_t x_t' / x_n' at a landing: by it v falls when the landing comes early.
  double landing_slope(int direction, int instant) const { return sliders_[direction].landing_slope(instant); }

private:
  bool surely_stuck(const ContactPoint &point, const std::array<double, 2> &v) const;
  bool rests(int direction) const;
  void find_spans();
  void sample_closed(const double *x, double *value, double *slope) const;
  void march(int direction, double v);
  void add(double begin, int from, double end, int to, double weight, MaskMeans &mask) const;
  void normal(const ContactPoint &point, double *G, Linearisation &linear) const;
  void tangential(const ContactPoint &point, int direction, const double *X, double *G, Linearisation &linear);
  void add_stick(const ContactPoint &point, int direction, std::size_t stretch, double *G, Linearisation &linear);
  double slipping() const;
  int changes(int direction) const;

  int harmonics_;
  Grid grid_;
  Instants instants_;
  std::array<Slider, 2> sliders_;
  Trigonometric approach_;              // p = x_n - x_n0
  std::vector<double> p_;               // its coefficients (2H+1)
  std::vector<double> values_, slopes_; // (3, ends) on the grid: x_t1, x_t2, p
  std::vector<Span> spans_;             // in the order of time
  bool always_closed_ = false;
  std::array<std::vector<Stretch>, 2> run_; // of the period that counts, one span after the other
  std::vector<Stretch> first_round_;
  std::vector<double> inverse_; // 1 / (2 pi m), m = 0..2H, 0 for m = 0
  std::vector<double> share_;   // (2H+1) of a stretch that nothing hangs on
};

} // namespace dovetail
