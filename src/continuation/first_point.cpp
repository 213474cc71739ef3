// Where a branch begins: from rest or the motion given, by Newton; if that fails by easier problems that lead there.
#include <cmath>

#include "continuation/follower.hpp"
#include "transient/steady_state.hpp"

namespace dovetail {
namespace {

constexpr PetscInt most_dofs = 300; // of a model that is integrated in time

// The coefficients as far as both have them, the rest zero.
std::vector<double> resized(const std::vector<double> &q, int dofs, int width) {
  const int old = static_cast<int>(q.size()) / dofs;
  std::vector<double> out(static_cast<std::size_t>(dofs) * width, 0.0);
  for (int d = 0; d < dofs; ++d)
    for (int i = 0; i < std::min(old, width); ++i) out[d * width + i] = q[d * old + i];
  return out;
}

} // namespace

bool Follower::first_point(Vec y, Station &first, std::string &how) {
  const Layout &layout = system_->layout();
  const double w = settings_.from;
  check(VecCopy(y, first.y), "starting");
  if (curve_->solve_at(w, first)) return true;
  summary_.why = "no solution was found at the first frequency: " + first.newton.why + difference();
  const std::string alas = "Newton does not converge from rest; ";

  const auto through = [&](HarmonicSystem &easier, std::vector<double> &q) { // q becomes the solution of `easier`
    Curve curve(easier, newton_, omega_unit_, settings_.adaptive, summary_.counts);
    Station s = curve.station();
    set_coefficients(easier.layout(), resized(q, static_cast<int>(layout.dofs()), easier.layout().width), s.y);
    if (!curve.solve_at(w, s)) return false;
    q = all_coefficients(easier.layout(), s.y);
    return true;
  };
  const auto arrive = [&](const std::vector<double> &q, const std::string &by) {
    set_coefficients(layout, resized(q, static_cast<int>(layout.dofs()), layout.width), first.y);
    if (!curve_->solve_at(w, first)) return false;
    how += (how.empty() ? "" : "; ") + alas + by;
    return true;
  };
  const std::vector<double> begin = all_coefficients(layout, y);

  std::vector<double> q = begin;
  bool good = true;
  for (int H = 1; good && H < system_->harmonics(); H = std::max(H + 1, static_cast<int>(std::lround(1.4 * H)))) {
    HarmonicSystem easier(*system_, H, system_->samples());
    good = through(easier, q);
  }
  if (good && arrive(q, "the first point comes from fewer harmonics")) return true;

  q = begin, good = true;
  for (double part = 1.0 / 1024; good && part < 1; part *= 2) {
    HarmonicSystem easier(*system_, system_->harmonics(), system_->samples(), part);
    good = through(easier, q);
  }
  if (good && arrive(q, "the first point comes from softer contacts")) return true;

  if (layout.dofs() > most_dofs) return false;
  const SteadyState steady = steady_state(dense_model(*system_), w, {}, {system_->harmonics()});
  return steady.settled && arrive(steady.coefficients, "the first point comes from time integration");
}

} // namespace dovetail
