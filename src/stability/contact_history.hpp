#pragma once
// What all contact points do over one period, as time between merged instants in which nothing changes: what the
// linearised motion is integrated over.
#include <vector>

#include "contact/exact_law.hpp"

namespace dovetail {

/// How a direction of a contact point answers small changes of the motion.
enum class Answer : char {
  free,   ///< not at all: open, or without friction
  spring, ///< by its stiffness: closed (normal); stuck all round on a slider that nothing moves (tangential)
  held,   ///< sticks on a slider that was set by an event of this period: T = k_t x - v
  forth,  ///< slips, T = mu k_n p
  back    ///< slips, T = -mu k_n p
};

struct ContactHistory {
  /// A stick that an event begins, at `begin` in [0, 2 pi); `end` may lie in the next period. There
  /// dv = by_t dx_t + by_n dx_n, and no change of v later on.
  struct Hold {
    int slider;   ///< 2 point + direction
    int interval; ///< number of the one that begins with it
    double begin, end;
    double by_t, by_n; ///< [N/m]
  };

  int points = 0;
  std::vector<double> ends;    ///< (intervals + 1) instants from 0 to 2 pi, in order
  std::vector<Answer> answers; ///< (intervals, points, 3): t1, t2, n
  std::vector<Hold> holds;     ///< in no order

  int intervals() const { return static_cast<int>(ends.size()) - 1; }
  const Answer *interval(int i) const { return &answers[static_cast<std::size_t>(i) * 3 * points]; }
  bool linear() const { return intervals() == 1 && holds.empty(); } ///< nothing changes
};

/// Collects it point by point: begin(), one of the two for every point in order, finish().
class HistoryWriter {
public:
  void begin();
  void add_steady(const ContactPoint &point, bool closed);  ///< always stuck, or always open
  void add(const ContactPoint &point, const ExactLaw &law); ///< as just evaluated by `law`, which found some instants
  void finish();
  const ContactHistory &history() const { return history_; }

private:
  struct Segment { // of direction 3 point + d, not across the period's end
    int place;
    double begin, end;
    Answer answer;
  };
  void cover(int place, double begin, double end, Answer answer);
  void add_direction(const ContactPoint &point, const ExactLaw &law, int direction);

  ContactHistory history_;
  std::vector<Segment> segments_;
};

} // namespace dovetail
