#pragma once
// A point of the branch and what happened there, in user units: what one line on the screen and one row of the file
// need.
#include <string>
#include <vector>

#include "analyses/branch.hpp"
#include "results/gather.hpp"

namespace dovetail {

/// What every contact point did over the period; (N_x,) each.
struct ContactRecord {
  std::vector<double> stick, slip, open; ///< shares of the period
  std::vector<double> dissipation;       ///< energy per period [J]
  std::vector<int> events;
};

/// Complete on rank 0 only.
struct PointRecord {
  double omega = 0;     ///< [rad/s]
  double parameter = 0; ///< what is followed over, where that is not the frequency
  double arclength = 0; ///< scaled
  int harmonics = 0;
  int located = 0; ///< 1: within a step
  int newton = 0, linear = 0;
  double residual = 0;                  ///< scaled
  double seconds = 0;                   ///< since the point before
  double stick = 0, slip = 0, open = 0; ///< shares of the contact points
  double progress = 0;
  int stable = 0, instability = 0; ///< numbers of Stability's Verdict and Kind, where points are judged
  double multiplier = 0;
  double harmonics_error = 0, sampling_error = 0, modes_error = 0; ///< where they are estimated
  double amplitude = 0;                                            ///< of what is watched, half its peak-to-peak
  double tracked = 0;       ///< of the same, sqrt(sum over k >= 1 of a_k^2 + b_k^2)
  int unknown = -1;         ///< that it is of: a row of coefficients, or -1 for the node that the case names
  double between_error = 0; ///< of the amplitude since the point before; NaN: unknown
  // Of a nonlinear mode, over whose amplitude `parameter` is:
  double damping_ratio = 0;   ///< zeta, of the resonance
  double friction_energy = 0; ///< per period [J]
  double force_level = 0;     ///< multiple of the load at whose phase resonance this is the response
  double energy_error = 0;    ///< of the balance of energies, as a damping ratio
  ContactRecord contact;
  std::vector<double> coefficients; ///< (N_a + 3 N_x, 2H+1) [user units]
  std::vector<double> tangent;      ///< of a response: the same by arc length, and
  double tangent_parameter = 0;     ///< what it is followed over by arc length
  double tangent_omega = 0;         ///< of followed peaks: omega by arc length
};

/// Something on the way along the branch.
struct EventRecord {
  int kind = 0;         ///< number of a BranchEvent::Kind
  int point = 0;        ///< the last point before it, or the point that it is
  double omega = 0;     ///< [rad/s]
  double amplitude = 0; ///< of what is watched [user units]; 0 unless it is a place on the curve
  int unknown = -1;     ///< that the amplitude is of, as in PointRecord
  double parameter = 0; ///< where it is not the frequency
};

/// An unknown in words: "a1", "x3.n", or `watch`, the node that the case names.
std::string name_of_unknown(int unknown, PetscInt modes, const std::string &watch);

/// The first and the last two points of a curve, as far as it did not jump between them.
class CurveEnds {
public:
  struct End {
    double value; ///< of the parameter
    double amplitude;
    int unknown;
  };
  /// `begins`: the first point is that of the curve, not of a run that is continued.
  explicit CurveEnds(bool begins = true) : first_known_(!begins) {}
  void add(const End &point);
  void jump() { last_.clear(), first_known_ = true; }
  const End *falling() const; ///< the first point, if the amplitude falls behind it; else null
  const End *rising() const;  ///< the last point, if the amplitude rises before it; else null

private:
  bool first_known_; // all that there will be
  std::vector<End> first_, last_;
};

/// Of a point, how far it is from the exact curve.
struct EstimateRecord {
  double omega = 0;                              ///< [rad/s]
  double harmonics = 0, sampling = 0, modes = 0; ///< see ErrorEstimate
  double between = 0;                            ///< see BranchPoint
  double parameter = 0;                          ///< where it is not the frequency
  double open = 0;                               ///< share of the contact points

  double total() const { return harmonics + sampling + modes; }
};

/// The names of BranchEvent::Kind, by their numbers.
const std::vector<const char *> &event_names();

/// Collects a point from all ranks, but for the value of its parameter. `scale`: of these values, for the tangent.
/// Collective.
PointRecord collect(const BranchPoint &point, double seconds, double scale);

} // namespace dovetail
