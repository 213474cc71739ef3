#include "app/choose_modes.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "app/follow.hpp"

namespace dovetail {
namespace {

constexpr int few = 20;       // modes to begin with: 16 at most are residuals
constexpr double part = 0.25; // of the tolerance, for modes left out: they cost little in what follows
constexpr int most_tried = 5; // reductions

struct Trial {
  double error = 0; // by modes left out, the largest of all points
  int points = 0;   // that have an estimate of it
};

// About what the tolerance will ask for, where forces have corners and errors fall like H^-3: high harmonics excite
// high modes.
int harmonics_of(const Case &study) {
  constexpr double most = 64; // no run by tolerance takes more
  const double wanted = std::min(most, 1.5 * std::pow(study.tolerance, -1.0 / 3));
  return std::max(2 * study.harmonics + 1, static_cast<int>(wanted));
}

Trial along_the_curve(const Case &study, PreloadedModel preloaded) {
  const Scales scales = choose_scales(study, preloaded);
  const auto whole = harmonic_system(study, std::move(preloaded), scales, harmonics_of(study), exactly);
  HarmonicSystem &system = *whole;
  BranchSettings settings = settings_of(study, system);
  settings.stability = false, settings.tolerance = 0, settings.at.clear();
  Trial trial;
  BranchObserver observer;
  observer.point = [&](const BranchPoint &point) {
    if (!point.error || !std::isfinite(point.error->modes)) return;
    ++trial.points;
    trial.error = std::max(trial.error, point.error->modes);
  };
  observer.event = [](const BranchEvent &) {};
  observer.state = [](const BranchState &) {};
  UniqueVec y = system.unknowns();
  follow_branch(system, {study.step_tolerance, study.residual_tolerance, study.max_iterations}, settings, y, observer,
                nullptr);
  return trial;
}

} // namespace

void first_modes(Case &study, PetscInt most) {
  study.modes = static_cast<int>(std::min<PetscInt>(few, std::max<PetscInt>(most, 0)));
  const std::filesystem::path file = study.directory / "reduced.h5";
  std::error_code unreadable;
  if (!std::filesystem::exists(file, unreadable)) return;
  try {
    study.modes = static_cast<int>(
        std::clamp<PetscInt>(read_reduced_header(file).modes, study.modes, std::max<PetscInt>(most, study.modes)));
  } catch (const InputError &) { // damaged or foreign: it will be written anew, or refused
  }
}

ReducedModel reduced_to_tolerance(MPI_Comm comm, Case &study, PetscInt most, const std::filesystem::path &file,
                                  const std::vector<ContactPoint> &contact, const std::vector<double> &initial,
                                  Stages &stages, const Voice &voice, std::optional<ReductionFigures> &figures) {
  for (int tried = 1;; ++tried) {
    ReducedModel reduced = reduced_model(comm, study, file, stages, voice, figures);
    if (reduced.left_out.squares.empty()) return reduced; // nothing
    if (tried == most_tried) {
      voice.say("modes: no more than " + std::to_string(study.modes) + " are tried");
      return reduced;
    }
    const Trial trial = stages.run("3 modes tried", [&] {
      const Range own = reduced.own_points;
      std::string note;
      return along_the_curve(study,
                             contact_preload(reduced, {contact.begin() + own.begin, contact.begin() + own.end},
                                             {initial.begin() + 3 * own.begin, initial.begin() + 3 * own.end}, note));
    });
    char line[160];
    if (trial.points == 0) {
      voice.say("modes: what " + std::to_string(study.modes) + " leave out is not known, a trial run found nothing");
      return reduced;
    }
    std::snprintf(line, sizeof line,
                  "modes: %d leave out %.1e at most of the motion (%d points of a trial run), %.1e allowed",
                  study.modes, trial.error, trial.points, part * study.tolerance);
    voice.say(line);
    const int more = static_cast<int>(std::min<PetscInt>(2 * study.modes, most));
    if (!(trial.error > part * study.tolerance)) return reduced;
    if (more == study.modes) {
      if (study.interior_modes > 0)
        voice.say("modes: the " + std::to_string(study.interior_modes) +
                  " interior modes make no more of them; raise reduction.interior_modes, or delete it");
      return reduced;
    }
    study.modes = more;
  }
}

} // namespace dovetail
