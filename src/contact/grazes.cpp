// Grazes of the motion that the exact law has evaluated last, eq (E).
#include <algorithm>
#include <cmath>

#include "contact/exact_law.hpp"
#include "contact/fourier.hpp"

namespace dovetail {
namespace {

constexpr double period = 2 * M_PI;
constexpr double same_instant = 1e-7; // [rad], where an edge that is highest there has ended a slip
constexpr int per_wave = 32;          // places of a wave that are looked at
constexpr int bisections = 60;

// An edge s k_t x - mu k_n p with its slope, from coefficients.
struct Edge {
  std::vector<double> c;
  double value(double theta) const {
    double sum = c[0] / 2;
    for (std::size_t k = 1; 2 * k < c.size(); ++k)
      sum += c[2 * k - 1] * std::cos(k * theta) + c[2 * k] * std::sin(k * theta);
    return sum;
  }
  double slope(double theta) const {
    double sum = 0;
    for (std::size_t k = 1; 2 * k < c.size(); ++k)
      sum += k * (c[2 * k] * std::cos(k * theta) - c[2 * k - 1] * std::sin(k * theta));
    return sum;
  }
  double size() const {
    double sum = std::abs(c[0] / 2);
    for (std::size_t k = 1; 2 * k < c.size(); ++k) sum += std::hypot(c[2 * k - 1], c[2 * k]);
    return sum;
  }
  std::vector<double> highest_places() const {
    std::vector<double> found;
    const int count = per_wave * static_cast<int>(c.size());
    for (int i = 0; i < count; ++i) {
      double from = i * period / count, to = (i + 1) * period / count;
      if (!(slope(from) > 0 && slope(i + 1 < count ? to : 0) <= 0)) continue; // at 2 pi not another zero than at 0
      for (int j = 0; j < bisections; ++j) (slope((from + to) / 2) > 0 ? from : to) = (from + to) / 2;
      found.push_back(to);
    }
    return found;
  }
};

double apart(double a, double b) { return std::abs(std::remainder(a - b, period)); }

bool holds(const Stretch &s, double theta) {
  for (const double turn : {0.0, period})
    if (theta + turn >= s.begin - same_instant && theta + turn <= s.end + same_instant) return true;
  return false;
}

// out += factor times the row of the synthesis at theta
void add_row(double factor, double theta, std::vector<double> &out) {
  out[0] += factor / 2;
  for (std::size_t k = 1; 2 * k < out.size(); ++k)
    out[2 * k - 1] += factor * std::cos(k * theta), out[2 * k] += factor * std::sin(k * theta);
}

} // namespace

std::vector<Graze> ExactLaw::grazes(const ContactPoint &point, const Standstill &standstill, const double *X) const {
  std::vector<Graze> found;
  const int n = coefficient_count(harmonics_);
  for (int d = 0; d < 2 && has_friction(point.law); ++d) {
    if (point.mu[d] == 0 || approach_.mean() + approach_.bound(0) <= 0) continue;
    std::vector<Stretch> run = run_[d];
    if (run.empty()) {
      run.push_back(sticking(point.kt[d] * (standstill.w[d] - standstill.x[d]), -1, 0));
      run[0].end = period;
    }
    for (const int side : {1, -1}) {
      Edge edge{std::vector<double>(n)};
      for (int i = 0; i < n; ++i) edge.c[i] = side * point.kt[d] * X[d * n + i] - point.mu[d] * point.kn * p_[i];
      for (const double theta : edge.highest_places()) {
        // the slip that ends there, else the rest at that time; then what was before the slip
        auto at = std::find_if(run.begin(), run.end(), [&](const Stretch &s) {
          return s.side == side && (apart(s.end, theta) < same_instant || holds(s, theta));
        });
        const bool slips = at != run.end();
        for (std::size_t i = 0; slips && i < run.size() && at->side == side; ++i) {
          const auto before = at == run.begin() ? run.end() - 1 : at - 1;
          if (before->to != at->from) break; // it lands slipping
          at = before;
        }
        if (!slips) at = std::find_if(run.begin(), run.end(), [&](const Stretch &s) { return holds(s, theta); });
        if (at == run.end() || at->side != 0) continue;
        const bool set = at->set_at >= 0;
        const double from = set ? instants_[at->set_at].theta : 0;
        if (set && at->set_by == side && apart(from, theta) < same_instant) continue; // what set it
        Graze graze{d,
                    side,
                    theta,
                    edge.value(theta) - side * at->v,
                    edge.size(),
                    std::vector<double>(n),
                    std::vector<double>(n)};
        add_row(side * point.kt[d], theta, graze.by_t);
        add_row(-point.mu[d] * point.kn, theta, graze.by_n);
        if (set) {
          const double by_n =
              at->set_by != 0 ? at->set_by * point.mu[d] * point.kn : sliders_[d].landing_slope(at->set_at);
          add_row(-side * point.kt[d], from, graze.by_t);
          add_row(side * by_n, from, graze.by_n);
        }
        found.push_back(std::move(graze));
      }
    }
  }
  return found;
}

} // namespace dovetail
