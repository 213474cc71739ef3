#pragma once
// One way on where steps along a curve lead nowhere, and what it may ask for. A strategy is policy: where to try, in
// which order, when to give up. What a try is says the analysis that follows the curve, as a RecoveryContext.
#include <string>
#include <vector>

#include "recovery/strategies.hpp"

namespace dovetail {

/// Why the curve does not go on.
struct Failure {
  enum class Kind {
    no_start, ///< no solution is found at a value of the parameter where a curve is to begin
    nowhere,  ///< nor by what else there is for that
    no_step,  ///< no step converges, however short
    crowded,  ///< folds crowd, and nothing else comes
    drifting, ///< nothing but mean positions changes
    lost      ///< whatever it was, nothing has helped: the curve is left where it had come farthest
  } kind;
  std::string why;
  double from; ///< value of the parameter beyond which solutions are wanted; no_start, nowhere: at which one is
};

/// Along one curve: each says that it may be another branch from there on.
constexpr int most_jumps = 50;

class RecoveryContext {
public:
  virtual ~RecoveryContext() = default;

  struct Sweep {
    double from, to;        ///< of the parameter
    std::vector<double> at; ///< wanted exactly, between them
  };
  virtual Sweep sweep() const = 0;
  /// True ends all trying: the user wants to stop.
  virtual bool interrupted() = 0;
  virtual int jumps() const = 0; ///< that were made so far

  // Tries. Each returns false where it failed, and then the curve stands where it stood.
  /// The solution at that value of the parameter, by Newton's method from the last point, or from rest.
  virtual bool solve_at(double value) = 0;
  /// The same from the steady state that time integration finds. `share`: of the work that is left for it.
  virtual bool integrate_at(double value, double share) = 0;
  /// The same from simpler models of the structure, each begun at the solution of the one before.
  virtual bool solve_by_simpler(double value) = 0;
  /// A sweep from `from` to `to` instead: its first point, by Newton's method and what handles no_start.
  virtual bool begin_at(double from, double to) = 0;

  /// After solve_at, or integrate_at (`integrated`), away from the last point: the curve goes on there.
  virtual void go_on(const Failure &failure, bool integrated) = 0;
};

class RecoveryStrategy {
public:
  virtual ~RecoveryStrategy() = default;
  virtual bool handles(Failure::Kind kind) const = 0;
  /// On beyond the failure. False: nothing has changed, but work was spent.
  virtual bool attempt(const Failure &failure, RecoveryContext &context) const = 0;
};

/// Values of the parameter ahead of `from`, at these parts of the sweep, up to its end. Before each one the nearest of
/// Sweep::at that lies between it and the one before.
std::vector<double> ahead(const RecoveryContext::Sweep &sweep, double from, const std::vector<double> &parts);

/// Tries those in the list that handle the failure, in its order. False where none has helped, or the user wants to
/// stop.
bool recover(const Strategies &strategies, const Failure &failure, RecoveryContext &context);

} // namespace dovetail
