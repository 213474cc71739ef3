// What is wrong with a curve that has been computed, by its results file.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "analyses/branch.hpp"
#include "app/earlier_run.hpp"
#include "app/tell_resonances.hpp"
#include "case/undamped.hpp"
#include "support/hdf5.hpp"

namespace dovetail {
namespace {

class StoredCurve { // as it stands in the file
public:
  StoredCurve(const std::filesystem::path &file, std::size_t contact_points)
      : file_(file), omega_(file_.doubles("/points/omega")), points_(contact_points) {}

  std::size_t size() const { return omega_.size(); }
  double omega(std::size_t i) const { return omega_[i]; }
  std::vector<double> residuals() const { return file_.doubles("/points/residual"); }

  bool has_peak() const {
    const std::vector<long> kinds = file_.integers("/events/kind");
    return std::count(kinds.begin(), kinds.end(), static_cast<long>(BranchEvent::Kind::peak)) > 0;
  }

  bool slips(std::size_t i) const {
    const std::vector<double> share = row("slip", i);
    return std::any_of(share.begin(), share.end(), [](double value) { return value > 0; });
  }

  /// Whether every contact point stays as it is at rest, closed and stuck or open, so that the structure is linear.
  bool rests(std::size_t i, hsize_t closed) const {
    const std::vector<double> stick = row("stick", i), open = row("open", i);
    const auto whole = [](const std::vector<double> &share) {
      return static_cast<hsize_t>(std::count(share.begin(), share.end(), 1.0));
    };
    return whole(stick) == closed && whole(open) == points_ - closed;
  }

private:
  std::vector<double> row(const char *what, std::size_t i) const {
    if (points_ == 0) return {};
    return file_.doubles(std::string("/points/contact/") + what, {i, 0}, {1, points_});
  }

  h5::Reader file_;
  std::vector<double> omega_;
  hsize_t points_;
};

// The resonances of the stuck structure that the curve steps over while it is that structure. Without damping its
// response has no bound there.
void passed_over(const Resonances &found, const Case &study, const StoredCurve &curve, std::vector<Warning> &warnings) {
  for (std::size_t j = 0; j < found.stuck.omega.size(); ++j)
    for (const int k : found.driven[j]) {
      const double place = found.stuck.omega[j] / k;
      if (place <= std::min(study.omega_from, study.omega_to) || place >= std::max(study.omega_from, study.omega_to))
        continue;
      for (std::size_t i = 1; i < curve.size(); ++i) {
        if ((curve.omega(i - 1) - place) * (curve.omega(i) - place) > 0) continue;
        if (!curve.rests(i - 1, found.closed) || !curve.rests(i, found.closed)) continue;
        warnings.push_back(
            {"undamped_resonance",
             "between " + study.frequency_unit.text(curve.omega(i - 1)) + " and " +
                 study.frequency_unit.text(curve.omega(i)) +
                 " the curve steps over a resonance of the stuck structure" +
                 (k > 1 ? " (harmonic " + std::to_string(k) + ")" : "") + ", at " + study.frequency_unit.text(place) +
                 ": without damping, and with no contact that moves, the response has no bound there. Give "
                 "damping.stiffness"});
        break;
      }
    }
}

// Points are taken whose residual no iteration lowers.
void rounded(const StoredCurve &curve, double tolerance, std::vector<Warning> &warnings) {
  const std::vector<double> residuals = curve.residuals();
  const auto count =
      std::count_if(residuals.begin(), residuals.end(), [tolerance](double residual) { return residual >= tolerance; });
  if (count == 0) return;
  char words[400];
  std::snprintf(words, sizeof words,
                "at %td of %zu points rounding errors leave a residual of up to %.1e, more than "
                "newton.residual_tolerance = %.1e: forces cancel that are much larger than the load. Something in the "
                "model is very stiff, or hardly damped. Rigid links are stiff enough with a thousand to a million "
                "times the stiffness of what they join",
                count, residuals.size(), *std::max_element(residuals.begin(), residuals.end()), tolerance);
  warnings.push_back({"rounding", words});
}

} // namespace

std::vector<Warning> warnings_of_curve(const std::optional<Resonances> &found, const Case &study,
                                       const std::vector<ContactPoint> &contact, bool finished) {
  std::vector<Warning> warnings;
  const StoredCurve curve(results_of(study), contact.size());
  const bool friction = std::any_of(contact.begin(), contact.end(), [](const ContactPoint &point) {
    return has_friction(point.law) && std::max(point.mu[0], point.mu[1]) > 0;
  });
  bool slips = !friction || !finished || curve.size() == 0;
  for (std::size_t i = 0; i < curve.size() && !slips; ++i) slips = curve.slips(i);
  if (!slips)
    warnings.push_back({"no_slip", "no contact point slips at any point of the curve: friction does nothing, its "
                                   "springs k_t alone are seen. A larger load, or less clamping or friction, makes it "
                                   "slip"});
  if (found && finished && !curve.has_peak())
    if (const auto warning = no_peak(*found, study)) warnings.push_back(*warning);
  const std::size_t before = warnings.size();
  if (found && undamped(study.damping)) passed_over(*found, study, curve, warnings);
  const bool no_bound = warnings.size() > before; // beside which any motion has large forces that cancel
  if (!study.follows_peaks() && !no_bound) rounded(curve, study.residual_tolerance, warnings);
  return warnings;
}

} // namespace dovetail
