#pragma once
// What is continued: F(x, p) = 0, whose solutions are a curve in y = [x; p]. The engine of this folder knows no more of
// it than this page.
#include <array>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "support/handle.hpp"
#include "support/linear_effort.hpp"

namespace dovetail {

/// The last unknown: what the curve is followed over.
struct Parameter {
  std::string name; ///< for messages, as "frequency"
  std::string unit; ///< "-" where it has none
};

/// The matrix of [F(y); border . y - target], with what solves with it.
class BorderedJacobian {
public:
  virtual ~BorderedJacobian() = default;
  virtual Mat matrix() const = 0;
  /// Makes `ksp` solve with the matrix. Before KSPSetFromOptions.
  virtual void set_up(KSP ksp) = 0;
  /// Fills the matrix at y, with that last row. Collective.
  virtual void assemble(Vec y, Vec border) = 0;
  /// Sign of the determinant of the matrix solved with last: +1 or -1; 0 where the solver does not tell.
  virtual int determinant_sign(KSP) { return 0; }
  /// After a solve that failed: what went wrong, in words; `ksp` is fit for the next.
  virtual std::string recover(KSP) { return "the linear solver failed"; }
  /// What solves took since last asked; `solves`: iterations of `ksp`.
  virtual LinearEffort take_effort(int solves) { return {solves, 0}; }
  /// Operations spent since last asked, roughly; infinite where they are not counted.
  virtual double take_work() { return std::numeric_limits<double>::infinity(); }
  /// What the solver has learned, as a number, and a beginning with nothing but that: a restart does the same then.
  /// `for_one`: a single Jacobian follows, of which factors serve no other.
  virtual double memory() const { return 0; }
  virtual void begin(double /*memory*/, bool /*for_one*/) {}
};

/// How arc length is measured: a scalar product on y.
class ArcLengthMetric {
public:
  virtual ~ArcLengthMetric() = default;
  using Pair = std::array<Vec, 2>;
  /// Products of pairs, then squares of how far `moving` move, without weights, by one message; by which parameter_of
  /// the vectors `known` is known as well. Collective.
  virtual std::vector<double> products(const std::vector<Pair> &pairs, const std::vector<Vec> &moving = {},
                                       const std::vector<Vec> &known = {}) const = 0;
  double product(Vec a, Vec b) const { return products({{a, b}})[0]; } ///< Collective.
  virtual void weigh(Vec t, Vec row) const = 0;                        ///< row . s is the product of t and s
  /// The largest motion met at accepted points; weights may follow it.
  virtual double largest_motion() const = 0;
  virtual void see(Vec y) = 0; ///< an accepted point. Collective.
  double length(Vec t) const;
};

/// What a problem knows of a point besides its unknowns.
struct PointData {
  virtual ~PointData() = default;
};

class Problem {
public:
  virtual ~Problem() = default;
  virtual const Parameter &parameter() const = 0;
  /// y = [x; p], zero. p is the last entry, on the last rank.
  virtual UniqueVec unknowns() const = 0;
  /// f = F(y); its last entry is left alone. Collective.
  virtual void residual(Vec y, Vec f) = 0;
  /// The same; and border . y, which may travel with what F needs from other ranks. Collective.
  virtual double residual_and_plane(Vec y, Vec f, Vec border);
  virtual std::unique_ptr<BorderedJacobian> jacobian() = 0;
  /// `unit`: change of the parameter that counts as much as the largest motion. Not weighted: the plain norm.
  virtual std::unique_ptr<ArcLengthMetric> metric(double unit, bool weighted) const;
  /// Of the point whose residual was evaluated last.
  virtual std::shared_ptr<PointData> describe() { return nullptr; }
  virtual bool is_admissible(double /*parameter*/) const { return true; }
  /// False where F has kinks so close to each other that steps should not look for them one by one.
  virtual bool is_smooth() const { return true; }
  /// Whether pictures show cubics over the plain length of the curve.
  virtual bool is_drawn_by_cubics() const { return true; }
  /// Whether the motion may rise and fall within a small part of the parameter's range.
  virtual bool resonates() const { return true; }
  /// Of each vector the parameter and five projections of x, by which points are told apart cheaply. Collective.
  static constexpr int projections = 6;
  using Projected = std::array<double, projections>;
  std::vector<Projected> projected(const std::vector<Vec> &of) const;
  /// This rank's part of it: they are sums.
  virtual std::vector<Projected> own_projected(const std::vector<Vec> &of) const;
};

/// The last entry, on every rank. Collective; without a message where y is as it was when it was asked before.
double parameter_of(Vec y);
void note_parameter(Vec y, double value); ///< what all ranks know it to be
void set_parameter(Vec y, double value);  ///< the last entry
/// y *= factor; its parameter and its plain length, where all ranks know them, stay known.
void scale_known(Vec y, double factor);
/// 2-norm. Collective; without a message where t is as it was when it was asked before.
double plain_length(Vec t);
void note_plain_length(Vec t, double length);
void forget_plain_length(Vec t);
/// A number in (-1, 1), the same wherever it is asked for.
double pseudo_random(std::size_t a, std::size_t b, std::size_t which);

} // namespace dovetail
