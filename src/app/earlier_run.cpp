#include "app/earlier_run.hpp"

#include <algorithm>
#include <cmath>

#include "case/number_text.hpp"
#include "case/restart.hpp"
#include "harmonic/dense_model.hpp"
#include "results/summary.hpp"

namespace dovetail {
namespace {

namespace fs = std::filesystem;

constexpr const char *anew = "; begin anew without --restart";

fs::path aside(const fs::path &file) { return file.parent_path() / (file.stem().string() + ".old.h5"); }

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

bool was_cut_off(const fs::path &state) {
  try {
    return read_state(state).end.empty();
  } catch (const InputError &) { // none is there
    return false;
  }
}

} // namespace

SavedRun earlier_run(const Case &study, const std::vector<ContactPoint> &points, PetscInt dofs) {
  const fs::path path = state_of(study), results = results_of(study);
  if (!fs::exists(path))
    throw InputError(path.string() + ": no such file, so there is no run to continue in this folder" + anew);
  SavedRun run = read_state(path);
  refuse_other_problem(study, points, run.problem);
  const h5::Reader file(results);
  const auto shape = file.extent("/points/coefficients");
  if (shape.size() != 3 || shape[1] != static_cast<hsize_t>(dofs) ||
      run.branch.y.size() != static_cast<std::size_t>(dofs) * coefficient_count(run.branch.harmonics) + 1)
    throw InputError(file.place("/points/coefficients") + ": the model had another size when this run began" + anew);
  if (!holds(file, "/points/omega", run.branch.counts.points) || !holds(file, "/events/omega", run.events))
    throw InputError(results.string() + ": holds fewer points than " + path.string() + " knows of" + anew);
  const double here = run.branch.y.back() * run.scales.frequency;
  if ((study.omega_to - here) * (study.omega_to - study.omega_from) <= 0)
    throw InputError(study.given.at("continuation.omega") + ": continuation.omega ends at " +
                     number_text(study.omega_to) + " rad/s, but the run stands at " + number_text(here) + " already" +
                     anew);
  return run;
}

bool nothing_left(const Case &study, const SavedRun &run) {
  const bool good = run.end == name_of(BranchSummary::End::arrived) ||
                    run.end == name_of(BranchSummary::End::max_points) ||
                    run.end == name_of(BranchSummary::End::peaks) || run.end == name_of(BranchSummary::End::amplitude);
  return good && run.limits == limits_of(study);
}

void check_place(HarmonicSystem &system, const Case &study, const BranchState &state) {
  HarmonicSystem there(system, state.harmonics, state.samples);
  const Layout &layout = there.layout();
  UniqueVec y = there.unknowns(), f = there.unknowns();
  const auto size_at = [&](double factor) {
    std::vector<double> coefficients(state.y.begin(), state.y.end() - 1);
    for (double &value : coefficients) value *= factor;
    set_coefficients(layout, coefficients, y);
    double *own;
    check(VecGetArray(y, &own), "checking the state");
    if (layout.owns_omega()) own[layout.own_coefficients()] = state.y.back();
    check(VecRestoreArray(y, &own), "checking the state");
    there.residual(y, f);
    PetscReal size;
    check(VecNorm(f, NORM_2, &size), "checking the state");
    return size;
  };
  const double residual = size_at(1), force = size_at(0);
  if (residual <= std::max(100 * study.residual_tolerance, 1e-6 * force)) return;
  throw InputError(study.file.string() + ": the model, or its reduction, is not what it was when this run began: the " +
                   "residual where it stood is " + number_text(residual) + " instead of about 0" + anew);
}

void clear_output(const Case &study, const Voice &voice) {
  const fs::path results = results_of(study), state = state_of(study), old = aside(results);
  const hsize_t points = was_cut_off(state) ? points_in(results) : 0;
  if (points > 0 && points >= points_in(old)) {
    fs::rename(results, old);
    fs::rename(state, aside(state));
    voice.say("note: an earlier run was cut off after " + std::to_string(points) + " points; they are in " +
              old.string() + " now. (--restart would have continued it; rename " + old.filename().string() + " and " +
              aside(state).filename().string() + " back to do so.)");
  }
  for (const auto &file : {results, state}) fs::remove(file);
}

} // namespace dovetail
