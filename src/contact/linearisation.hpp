#pragma once
// Derivative of one contact point's force coefficients by its motion's coefficients, in the few numbers it consists of:
// how much of the period, and which part, the point spends in each state, and what each stick interval hangs on.
#include <array>
#include <vector>

#include "contact/contact_point.hpp"

namespace dovetail {

/// A (2H+1, 2H+1) block d G_row / d X_column of a point; 0 is t1, 1 is t2, 2 is n.
struct BlockPlace {
  int row, column;
};
/// The blocks that a law can make different from zero, in the order in which they are stored; or of the transpose.
const std::vector<BlockPlace> &block_places(Law law, bool transposed = false);

/// Means over the period, of a mask (1 in one state, 0 elsewhere) times cos m theta and sin m theta, m = 0..2H. They
/// are all it takes to multiply by the mask in the frequency domain: "gram" = analysis * mask * synthesis is a Toeplitz
/// plus a Hankel matrix of them.
struct MaskMeans {
  std::vector<double> cosine, sine; ///< (2H+1) each

  void reset(int harmonics);                    ///< nowhere 1
  void set_whole();                             ///< everywhere 1
  bool whole() const { return cosine[0] == 1; } // a sign or a gap anywhere makes the mean less
  double gram(int row, int column) const;       ///< an entry of it, by the places of coefficients [a0, a1, b1, ...]
  void add_gram_times(double factor, const double *v, double *out) const; ///< out += factor * gram v, (2H+1) each
};

class Linearisation {
public:
  void reset(int harmonics);

  bool springs_only = false;      ///< closed and stuck on w_p all round: the springs alone, nothing below is used
  MaskMeans closed;               ///< normal force acts
  int spans = 1;                  ///< times in the period that it does; the sampled laws do not count them
  std::array<MaskMeans, 2> stick; ///< per tangential direction
  std::array<MaskMeans, 2> slip;  ///< the same, times the sign of the slip

  /// One stick interval whose slider was set by an event: T = k_t x - v, where v changes with the motion.
  struct Run {
    int direction;
    std::vector<double> share;      ///< (2H+1) coefficients of the interval's indicator
    std::vector<double> by_t, by_n; ///< (2H+1) d(-v) / d X of that direction, and of n [N/m]
  };
  Run &add_run(int direction); ///< arrays sized, contents undefined
  const Run *begin() const { return runs_.data(); }
  const Run *end() const { return runs_.data() + count_; }

  /// For laws without such a structure: the blocks themselves, in the order of block_places; else empty.
  std::vector<double> dense;

  /// Writes the blocks, one after the other in the order of block_places, each row-major.
  void write(const ContactPoint &point, double *blocks) const;
  /// Only the rows and columns of those coefficients, (count, count) blocks; of laws that have the structure above.
  void write(const ContactPoint &point, const int *which, int count, double *blocks) const;
  /// The diagonal of the constant parts: d (mean of G_d) / d (mean of X_d), in order t1, t2, n [N/m].
  std::array<double, 3> mean_stiffness(const ContactPoint &point) const;
  /// out (3, 2H+1) = (d G / d X) v, without any block.
  void multiply(const ContactPoint &point, const double *v, double *out) const;

private:
  int harmonics_ = 0;
  std::vector<Run> runs_; // kept for their storage; count_ are in use
  std::size_t count_ = 0;
};

} // namespace dovetail
