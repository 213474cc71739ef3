#include "stability/contact_history.hpp"

#include <algorithm>
#include <cmath>

namespace dovetail {
namespace {

constexpr double period = 2 * M_PI;
constexpr double same_instant = 1e-10; // the same event found from two sides, or in two directions

bool coincide(double a, double b) {
  const double apart = std::abs(std::remainder(a - b, period));
  return apart < same_instant;
}

} // namespace

void HistoryWriter::begin() {
  history_.points = 0;
  history_.holds.clear();
  segments_.clear();
}

void HistoryWriter::cover(int place, double begin, double end, Answer answer) {
  if (begin >= period) begin -= period, end -= period;
  if (end > period) segments_.push_back({place, 0, end - period, answer});
  if (end > begin) segments_.push_back({place, begin, std::min(end, period), answer});
}

void HistoryWriter::add_steady(const ContactPoint &point, bool closed) {
  for (int d = has_friction(point.law) ? 0 : 2; closed && d < 3; ++d)
    cover(3 * history_.points + d, 0, period, Answer::spring);
  ++history_.points;
}

void HistoryWriter::add(const ContactPoint &point, const ExactLaw &law) {
  for (const ExactLaw::Span &span : law.spans()) cover(3 * history_.points + 2, span.begin, span.end, Answer::spring);
  for (int d = 0; d < 2; ++d) add_direction(point, law, d);
  ++history_.points;
}

void HistoryWriter::add_direction(const ContactPoint &point, const ExactLaw &law, int d) {
  const std::vector<Stretch> &run = law.run(d);
  const int place = 3 * history_.points + d;
  const auto set_here = [&](const Stretch &s) {
    return s.side == 0 && s.set_at >= 0 && coincide(law.instant(s.set_at), s.begin);
  };
  const bool moves = std::any_of(run.begin(), run.end(), [&](const Stretch &s) { return s.side != 0 || set_here(s); });
  for (std::size_t i = 0; i < run.size(); ++i) {
    const Stretch &s = run[i];
    if (s.side != 0) {
      cover(place, s.begin, s.end, s.side > 0 ? Answer::forth : Answer::back);
      continue;
    }
    cover(place, s.begin, s.end, moves && s.set_at >= 0 ? Answer::held : Answer::spring);
    if (!moves || !set_here(s)) continue;
    const double begin = s.begin < period ? s.begin : s.begin - period;
    double end = begin + s.end - s.begin;
    for (std::size_t k = 1; k < run.size(); ++k) { // goes on in the stretches that follow, perhaps beyond the period
      const Stretch &next = run[(i + k) % run.size()];
      if (next.side != 0 || set_here(next) || !coincide(next.begin, end)) break;
      end += next.end - next.begin;
    }
    // after a slip v = k_t x - side mu k_n p; at a landing v = k_t x at an instant that moves by -dx_n / x_n'
    const double by_n = s.set_by != 0 ? -s.set_by * point.mu[d] * point.kn : -law.landing_slope(d, s.set_at);
    history_.holds.push_back({2 * history_.points + d, 0, begin, end, point.kt[d], by_n});
  }
}

void HistoryWriter::finish() {
  std::vector<double> &ends = history_.ends;
  ends = {0, period};
  for (const Segment &s : segments_)
    for (const double theta : {s.begin, s.end}) ends.push_back(theta);
  std::sort(ends.begin(), ends.end());
  const auto last = std::unique(ends.begin(), ends.end(), [](double a, double b) { return b - a < same_instant; });
  ends.erase(last, ends.end());
  ends.back() = period;
  const std::size_t width = 3 * history_.points;
  history_.answers.assign(history_.intervals() * width, Answer::free);
  for (const Segment &s : segments_) {
    const int first =
        static_cast<int>(std::upper_bound(ends.begin(), ends.end(), s.begin + same_instant) - ends.begin()) - 1;
    for (int i = first; i < history_.intervals() && ends[i] + same_instant < s.end; ++i)
      history_.answers[i * width + s.place] = s.answer;
  }
  for (ContactHistory::Hold &hold : history_.holds)
    for (int i = 0; i < history_.intervals(); ++i)
      if (coincide(ends[i], hold.begin)) hold.interval = i;
}

} // namespace dovetail
