#include "app/ending.hpp"

#include "app/earlier_run.hpp"
#include "results/summary.hpp"
#include "support/signals.hpp"

namespace dovetail {

std::string in_words(const BranchSummary &summary, const Case &study, double scale, int signal) {
  using End = BranchSummary::End;
  const auto place = [&](double value) { return study.range().text(value * scale, 8); };
  const std::string where = place(summary.parameter);
  const std::string so_far = summary.counts.points == 0 ? "There is no point so far"
                                                        : "The " + std::to_string(summary.counts.points) +
                                                              " points so far are in " + results_of(study).string();
  switch (summary.end) {
  case End::arrived:
    return summary.why.empty() ? "" : summary.why + ", at " + where;
  case End::max_points:
  case End::peaks:
  case End::amplitude:
  case End::vanished:
    return summary.why + ", at " + where;
  case End::interrupted:
    if (summary.counts.points == 0)
      return "stopped by " + std::string(signal_name(signal)) + " before a first point was found";
    return "stopped by " + std::string(signal_name(signal)) + " at " + where + ". " + so_far +
           "; the same command with --restart goes on from there.";
  case End::no_start:
    if (study.follows_peaks())
      return summary.why + " (" + where + "). Widen continuation.omega, or begin at the other end of path.range.";
    if (study.mode) return summary.why + " (" + where + "). Fewer harmonics may help";
    return summary.why + " (" + where +
           "). Try the other end of the sweep, a start from other results (continuation.start), fewer harmonics, or a "
           "smaller load first.";
  default:
    if (study.follows_peaks())
      return "the peak could not be followed beyond " + where + ": " + summary.why + ". " + so_far +
             "; try a shorter path.range, or from the other end.";
    if (study.mode)
      return "the mode could not be followed beyond " + place(summary.farthest) + ": " + summary.why + ". " + so_far +
             ". Where contacts open, more harmonics help; or end mode.amplitude there.";
    return "the sweep could not go on beyond " + place(summary.farthest) + ": " + summary.why + ". " + so_far +
           (study.samples == exactly
                ? ". Where contacts open, more harmonics help"
                : ". Where contacts open, harmonic_balance.samples = \"exact\" and more harmonics help") +
           "; or sweep from the other end.";
  }
}

} // namespace dovetail
