#pragma once
// A solution at one value of the parameter, wherever it may come from. Nothing found changes nothing but the work
// spent.
#include <memory>
#include <optional>
#include <string>

#include "analyses/response.hpp"
#include "transient/steady_state.hpp"

namespace dovetail {

class PointSearch {
public:
  /// `work`: that time integration may take, so many times the default.
  PointSearch(const Response &response, double work, const Counts &counts)
      : response_(response), work_(work), counts_(counts) {}

  struct Found {
    CurvePoint point;
    std::string how;
    std::unique_ptr<HarmonicSystem> system; ///< with more harmonics, if it is no solution without; else null
  };
  /// By Newton's method from y, or from rest. Collective, like the others.
  std::optional<Found> by_newton(double value, Vec y);
  /// From the solution with one harmonic, then with more and more. `quickly`: with all of them at once if that will do,
  /// and given up where Newton's method wanders.
  std::optional<Found> by_fewer_harmonics(double value, Vec y, bool quickly);
  /// From the steady state that time integration finds, begun at y, null: rest. `share`: of the work that is left.
  std::optional<Found> by_integration(double value, Vec y, double share);

  double integrated() const { return integrated_; } ///< work that integration took
  void set_integrated(double work) { integrated_ = work; }
  void archive(Archive &archive) { archive.field("integrating", integrated_); }

private:
  int needed_harmonics(double value);
  double work_left() const;
  std::optional<Found> with_more_harmonics(double value, const SteadyState &steady);

  const Response &response_;
  const double work_;
  const Counts &counts_;
  double integrated_ = 0;
};

} // namespace dovetail
