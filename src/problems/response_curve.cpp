#include "problems/response_curve.hpp"

#include <cmath>
#include <vector>

#include "harmonic/left_out_forces.hpp"
#include "support/error.hpp"

namespace dovetail {
namespace {

constexpr const char *doing = "estimating what modes do that are left out";
constexpr double near = 0.1;           // relative, of their correction: the solves are right to a fifth
constexpr std::size_t most_tried = 12; // parts of it; what is unsolved then counts as an error

} // namespace

ResponseCurve::ResponseCurve(HarmonicSystem &followed, const NewtonSettings &newton, double unit, bool weighted,
                             SolveCounts &counts)
    : ForcedResponse(followed), Curve(static_cast<ForcedResponse &>(*this), newton, unit, weighted, counts),
      system(followed), unit_(unit), residual_(followed.unknowns()), correction_(followed.unknowns()) {}

// Its solves say nothing of what the curve's next ones take.
double ResponseCurve::left_out(const CurvePoint &s) {
  const double known = memory(), found = step_of_left_out(s);
  recall(known);
  return found;
}

// Newton's step of the equations with the modes left out: (J + L) c = r, L c their forces as they follow c. J alone
// would let the others answer as if those stood still meanwhile: far too much near a resonance of the others.
double ResponseCurve::step_of_left_out(const CurvePoint &s) {
  const double motion = std::sqrt(swing_product(system.layout(), s.y, s.y));
  if (motion == 0) return 0;
  const auto product = [&](Vec a, Vec b) {
    return swing_product(system.layout(), a, b) / (motion * motion) +
           system.parameter_in(a) * system.parameter_in(b) / (unit_ * unit_);
  };
  const Vec r = residual_, c = correction_;
  const LeftOutModes modes(system, s.y);
  const auto following = [&](Vec v) {
    return modes.motion(v, system.parameter().slope().load * system.parameter_in(v));
  };
  std::vector<double> own = modes.motion(s.y, system.setting().load);
  modes.forces(own, r);
  const double square = product(s.t, s.t);
  const auto solve = [&](Vec x) { // J x = r, across the curve: what lies along it does not count
    if (!correct(s, r, x)) return false;
    check(VecAXPY(x, -product(x, s.t) / square, s.t), doing);
    return true;
  };
  UniqueVec left = system.unknowns(); // of the equation c + J^-1 L c = J^-1 r
  if (!solve(left)) return std::nan("");
  check(VecSet(c, 0), doing);
  struct Tried {
    UniqueVec v, image; // a part of c, and the left-hand side for it: these are orthonormal
  };
  std::vector<Tried> tried;
  for (bool done = false; !done && tried.size() < most_tried;) { // generalised conjugate residuals
    auto &[v, image] = tried.emplace_back(Tried{system.unknowns(), system.unknowns()});
    check(VecCopy(left, v), doing);
    modes.forces(following(v), r);
    if (!solve(image)) break;
    check(VecAXPY(image, 1, v), doing);
    for (std::size_t i = 0; i + 1 < tried.size(); ++i) {
      const double part = product(image, tried[i].image);
      check(VecAXPY(image, -part, tried[i].image), doing);
      check(VecAXPY(v, -part, tried[i].v), doing);
    }
    const double size = std::sqrt(product(image, image));
    if (!(size > 0)) break;
    for (const Vec one : {Vec(image), Vec(v)}) check(VecScale(one, 1 / size), doing);
    const double part = product(left, image);
    check(VecAXPY(c, part, v), doing);
    check(VecAXPY(left, -part, image), doing);
    done = product(left, left) <= near * near * product(c, c);
  }
  const std::vector<double> less = following(c);
  double squares = 0;
  for (std::size_t i = 0; i < own.size(); ++i) squares += (own[i] - less[i]) * (own[i] - less[i]);
  return std::sqrt(product(c, c) + product(left, left) + // without modes those left out have no scale
                   (system.layout().modes > 0 ? squares / (motion * motion) : 0));
}

ResponseData &data_of(CurvePoint &s) { return static_cast<ResponseData &>(*s.data); }
const ResponseData &data_of(const CurvePoint &s) { return static_cast<const ResponseData &>(*s.data); }

} // namespace dovetail
