#include "app/earlier_run.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "analyses/saved_points.hpp"
#include "app/reduce.hpp"
#include "case/number_text.hpp"
#include "case/restart.hpp"
#include "harmonic/dense_model.hpp"
#include "results/summary.hpp"

namespace dovetail {
namespace {

namespace fs = std::filesystem;

constexpr const char *anew = "; begin anew without --restart";

hsize_t points_in(const fs::path &results) { // 0 also where the file is no results file at all
  try {
    return h5::Reader(results).extent("/points/omega").at(0);
  } catch (const std::exception &) {
    return 0;
  }
}

bool holds(const h5::Reader &file, const std::string &name, long rows) {
  const h5::Extent extent = file.extent(name);
  return extent.size() == 1 && rows >= 0 && extent[0] >= static_cast<hsize_t>(rows);
}

std::optional<SavedRun> saved(const fs::path &state) { // nothing where there is none, or one of another version
  try {
    return read_state(state);
  } catch (const InputError &) {
    return {};
  }
}

fs::path state_beside(const fs::path &results) { // results.old.2.h5: state.old.2.h5
  return results.parent_path() / ("state" + results.filename().string().substr(std::string("results").size()));
}

// Where the results in the folder go when a new run begins; nowhere if their run ended, or if a longer one of the same
// problem is kept already.
fs::path place_aside(const Case &study) {
  const std::optional<SavedRun> run = saved(state_of(study));
  if (run && !run->end.empty()) return {};
  const hsize_t points = points_in(results_of(study));
  for (int i = 1;; ++i) { // other problems, and files of others, keep their names
    const fs::path place = study.directory / ("results.old." + (i > 1 ? std::to_string(i) + "." : "") + "h5");
    if (!fs::exists(place) && !fs::exists(state_beside(place))) return place;
    const std::optional<SavedRun> kept = saved(state_beside(place));
    if (run && kept && run->problem == kept->problem) return points >= points_in(place) ? place : fs::path();
  }
}

// Unless the residual where the run stood is small, by what is in it.
void refuse_other_model(const Case &study, double residual, double force) {
  if (residual <= std::max(100 * study.residual_tolerance, 1e-6 * force)) return;
  throw InputError(study.file.string() + ": the model, or its reduction, is not what it was when this run began: the " +
                   "residual where it stood is " + number_text(residual) + " instead of about 0" + anew);
}

} // namespace

SavedRun earlier_run(const Case &study, const std::vector<ContactPoint> &points, PetscInt dofs) {
  const fs::path path = state_of(study), results = results_of(study);
  if (!fs::exists(path))
    throw InputError(path.string() + ": no such file, so there is no run to continue in this folder" + anew);
  SavedRun run = read_state(path);
  refuse_other_problem(study, points, run.problem);
  const h5::Reader file(results);
  check_format(file);
  if (file.text_attribute("run") != run.run)
    throw InputError(results.string() + ": belongs to another run than " + path.string() + " (its attribute run is \"" +
                     file.text_attribute("run") + "\", not \"" + run.run +
                     "\"); put back the one that does, or begin " + "anew without --restart");
  const auto shape = file.extent("/points/coefficients");
  if (shape.size() != 3 || shape[1] != static_cast<hsize_t>(dofs) ||
      run.branch.y.size() !=
          static_cast<std::size_t>(dofs) * coefficient_count(run.branch.harmonics) + (study.mode ? NonlinearMode::extra
                                                                                      : study.follows_peaks() ? 2
                                                                                                              : 1))
    throw InputError(file.place("/points/coefficients") + ": the model had another size when this run began" + anew);
  if (!holds(file, "/points/omega", run.branch.counts.points) || !holds(file, "/events/omega", run.events))
    throw InputError(results.string() + ": holds fewer points than " + path.string() + " knows of" + anew);
  const CurveRange range = study.range();
  const double here = place_of(study, run), way = study.mode ? 1 : range.to - range.from;
  if ((range.to - here) * way <= 0)
    throw InputError(study.given.at(range.key) + ": " + range.key + " ends at " + range.text(range.to) +
                     ", but the run stands at " + range.text(here) + " already" + anew);
  return run;
}

double place_of(const Case &study, const SavedRun &run) {
  const double last = run.branch.y.back();
  return study.mode ? std::pow(10, last) * run.scales.modal : last * run.scales.of(*study.range().parameter);
}

bool nothing_left(const Case &study, const SavedRun &run) {
  const bool good =
      run.end == name_of(BranchSummary::End::arrived) || run.end == name_of(BranchSummary::End::max_points) ||
      run.end == name_of(BranchSummary::End::peaks) || run.end == name_of(BranchSummary::End::amplitude) ||
      run.end == name_of(BranchSummary::End::vanished);
  return good && run.limits == limits_of(study);
}

void check_place(HarmonicSystem &system, const Case &study, const BranchState &state) {
  HarmonicSystem there(system, state.harmonics, state.samples);
  std::vector<double> solution = state.y;
  if (study.follows_peaks()) { // [Y; Omega; p]
    there.vary(ResponseParameter().beside(*study.path->parameter, solution.back()), there.preload());
    solution.pop_back();
  }
  UniqueVec y = there.unknowns(), f = there.unknowns();
  const auto size_at = [&](double factor) {
    std::vector<double> numbers = solution;
    for (std::size_t i = 0; i + 1 < numbers.size(); ++i) numbers[i] *= factor;
    set_numbers(there.layout(), std::move(numbers), y);
    there.residual(y, f);
    PetscReal size;
    check(VecNorm(f, NORM_2, &size), "checking the state");
    return size;
  };
  const double residual = size_at(1), force = size_at(0);
  refuse_other_model(study, residual, force);
}

void check_place(NonlinearMode &mode, const Case &study, const BranchState &state) {
  UniqueVec y = mode.unknowns(), f = mode.unknowns();
  const std::size_t omega = state.y.size() - NonlinearMode::extra;
  const auto size_at = [&](double factor) {
    std::vector<double> numbers = state.y;
    numbers[omega] *= factor;
    set_numbers(mode.system().layout(), std::move(numbers), y);
    mode.residual(y, f);
    PetscReal size;
    check(VecNorm(f, NORM_2, &size), "checking the state");
    return size;
  };
  const double residual = size_at(1), stiffness = size_at(0);
  refuse_other_model(study, residual, stiffness);
}

void look_around(const Case &study, const Voice &voice) {
  const fs::path results = results_of(study);
  const hsize_t points = points_in(results);
  if (points == 0) {
    for (const fs::path &file : {results, study.directory / "summary.json"}) fs::remove(file);
    return;
  }
  const fs::path aside = place_aside(study);
  if (aside.empty()) return;
  const bool readable = saved(state_of(study)).has_value();
  voice.say("note: an earlier run was cut off after " + std::to_string(points) + " points; with the first point of " +
            "this one they go to " + aside.string() +
            (readable ? ". (--restart would have continued it; rename " + aside.filename().string() + " and " +
                            state_beside(aside).filename().string() + " to results.h5 and state.h5 to do so.)"
                      : ""));
}

void make_room(const Case &study) {
  const fs::path results = results_of(study), state = state_of(study);
  if (const fs::path aside = fs::exists(results) ? place_aside(study) : ""; !aside.empty()) {
    fs::rename(results, aside);
    fs::remove(state_beside(aside));
    if (fs::exists(state)) fs::rename(state, state_beside(aside));
  } else {
    fs::remove(old_reduced(study.directory / "reduced.h5")); // of the results that go now
  }
  fs::remove(state);
}

} // namespace dovetail
