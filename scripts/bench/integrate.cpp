// Steady states of a case by time integration, the truth that harmonic balance is measured against.
//
//   build/integrate CASE.toml omega [omega ...] [--from results.h5] [--amplitude] [--periods 2000] [--tolerance 1e-6]
//                                               [--work 2e10]
//                                               [--harmonics N]
//   build/integrate CASE.toml omega --from results.h5 --along STEP [--points 500]
//
// On one rank. Reads the case, reduces the model or reads the reduced one, finds the preload state and integrates at
// each frequency [rad/s]: from rest there, or with --from from the point of that file nearest to it, so that it stays
// on that branch. --harmonics: of what is printed, the case's unless given. --periods and --work (multiplications)
// bound what one frequency may take. Prints one line of JSON for each: omega, settled, periods, change (between the
// last two, relative), multiplier (null unless shooting found the motion; beyond 1 it is unstable), seconds, and in
// user units, modes first, then t1, t2, n of each contact point, `coefficients` (n, 2H+1), or with --amplitude the
// largest |q - mean| over the cycle (n), from its course in time. Both are null where the numbers ran away or the work
// was used up.
//
// With --along the curve of motions is followed in time from the one of that file nearest to the frequency, towards the
// end of the case's sweep, in steps of STEP at most where the largest motion so far is 1; a line of omega and
// coefficients for each.
#include <slepc.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "app/reduce.hpp"
#include "results/gather.hpp"
#include "support/error.hpp"
#include "support/hdf5.hpp"
#include "support/mumps.hpp"
#include "transient/orbit_curve.hpp"
#include "transient/start.hpp"
#include "transient/steady_state.hpp"

namespace dovetail {
namespace {

struct Wish {
  std::filesystem::path file, from;
  std::vector<double> omegas;
  bool amplitude = false;
  double along = 0;
  int points = 500, harmonics = 0;
  IntegrationSettings settings;
};

Wish parse(const std::vector<std::string> &words) {
  Wish wish;
  wish.settings.periods = 2000;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const auto next = [&] {
      if (++i == words.size()) throw InputError(words[i - 1] + " wants a value behind it");
      return words[i];
    };
    if (words[i] == "--from")
      wish.from = next();
    else if (words[i] == "--amplitude")
      wish.amplitude = true;
    else if (words[i] == "--along")
      wish.along = std::stod(next());
    else if (words[i] == "--harmonics")
      wish.harmonics = std::stoi(next());
    else if (words[i] == "--points")
      wish.points = std::stoi(next());
    else if (words[i] == "--periods")
      wish.settings.periods = std::stoi(next());
    else if (words[i] == "--tolerance")
      wish.settings.tolerance = std::stod(next());
    else if (words[i] == "--work")
      wish.settings.work = std::stod(next());
    else if (wish.file.empty())
      wish.file = words[i];
    else
      wish.omegas.push_back(std::stod(words[i]));
  }
  if (wish.omegas.empty() || (wish.along > 0 && wish.from.empty()))
    throw InputError("wanted: CASE.toml and frequencies; see the head of integrate.cpp");
  return wish;
}

HarmonicSystem harmonic_system(const Case &study) {
  const MPI_Comm comm = PETSC_COMM_WORLD;
  Stages stages;
  std::optional<ReductionFigures> figures;
  ReducedModel reduced = reduced_model(comm, study, study.directory / "reduced.h5", stages, Voice(comm), figures);
  const ContactSettings from_model = study.reduced.empty() ? read_model_header(study.model).contact : ContactSettings{};
  const int points = static_cast<int>(reduced.points);
  std::string note;
  PreloadedModel preloaded = contact_preload(std::move(reduced), contact_points(study.contact, from_model, points),
                                             initial_preload(study, points), note);
  const Scales scales = choose_scales(study, preloaded);
  return HarmonicSystem(scaled(std::move(preloaded), study.damping, scales), study.harmonics, study.samples,
                        study.loads);
}

void print_numbers(const char *name, const std::vector<double> &values, int width) {
  std::printf(", \"%s\": ", name);
  if (values.empty()) std::printf("null");
  for (std::size_t i = 0; i < values.size(); ++i) {
    const char *open = i == 0 ? (width > 1 ? "[[" : "[") : width > 1 && i % width == 0 ? "], [" : ", ";
    std::printf("%s%.17g", open, values[i]);
  }
  if (!values.empty()) std::printf(width > 1 ? "]]" : "]");
}

// In user units.
void print_values(const char *name, std::vector<double> values, const DenseModel &model, const Scales &scales) {
  const int width = static_cast<int>(values.size()) / model.dofs();
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] *= static_cast<int>(i) < model.modes * width ? scales.modal : scales.contact;
  print_numbers(name, values, width);
  std::printf("}\n");
  std::fflush(stdout);
}

// Scaled, from the point of the file nearest to that frequency: as it was followed in time, or by its coefficients.
MotionState start_of(const Wish &wish, double omega, HarmonicSystem &system, const DenseModel &model) {
  const Scales &scales = system.scales();
  const h5::Reader file(wish.from);
  const std::vector<double> omegas = file.doubles("/points/omega");
  const auto far = [&](double a, double b) { return std::abs(a - omega) < std::abs(b - omega); };
  const hsize_t point = std::min_element(omegas.begin(), omegas.end(), far) - omegas.begin();
  const int n = model.dofs();
  const auto scale = [&](int dof) { return dof < model.modes ? scales.modal : scales.contact; };
  if (file.has("/points/state")) {
    const std::vector<double> numbers = file.doubles("/points/state", {point, 0}, {1, hsize_t(2 * (n + model.points))});
    MotionState out;
    for (int i = 0; i < n; ++i) out.q.push_back(numbers[i] / scale(i));
    for (int i = 0; i < n; ++i) out.v.push_back(numbers[n + i] / scale(i) / scales.frequency);
    for (std::size_t i = 2 * n; i < numbers.size(); i += 2)
      out.w.push_back({numbers[i] / scales.contact, numbers[i + 1] / scales.contact});
    if (std::isfinite(numbers[0])) return out;
  }
  const UniqueVec y = system.unknowns();
  start_from(wish.from, omega, system.layout(), scales, y);
  const Flow flow(model, omega / scales.frequency);
  return flow.motion_state(state_of(flow, all_coefficients(system.layout(), y)));
}

void integrate(const Wish &wish, const Case &study, HarmonicSystem &system) {
  const DenseModel model = dense_model(system);
  IntegrationSettings settings = wish.settings;
  settings.harmonics = wish.harmonics > 0 ? wish.harmonics : study.harmonics;
  for (const double omega : wish.omegas) {
    MotionState start;
    if (!wish.from.empty()) start = start_of(wish, omega, system, model);
    const auto began = std::chrono::steady_clock::now();
    const double scaled = omega / system.scales().frequency;
    const SteadyState steady = wish.from.empty() ? steady_state(model, scaled, {}, settings)
                                                 : steady_state_from(model, scaled, start, settings);
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - began;
    std::printf("{\"omega\": %.17g, \"settled\": %s, \"periods\": %d", omega, steady.settled ? "true" : "false",
                steady.periods);
    std::printf(std::isfinite(steady.change) ? ", \"change\": %.3g" : ", \"change\": null", steady.change);
    std::printf(steady.multiplier > 0 ? ", \"multiplier\": %.9g" : ", \"multiplier\": null", steady.multiplier);
    std::printf(", \"seconds\": %.4g", seconds.count());
    if (wish.amplitude)
      print_values("amplitude", steady.amplitude, model, system.scales());
    else
      print_values("coefficients", steady.coefficients, model, system.scales());
  }
}

void follow(const Wish &wish, const Case &study, HarmonicSystem &system) {
  const DenseModel model = dense_model(system);
  const Scales &scales = system.scales();
  const double omega = wish.omegas.front() / scales.frequency;
  const double way = study.omega_to - study.omega_from;
  OrbitCurve curve(model, omega, std::abs(way) / scales.frequency, wish.along);
  bool found = curve.begin(start_of(wish, wish.omegas.front(), system, model), way < 0 ? -1 : 1);
  for (int i = 0; found && i < wish.points; ++i) {
    std::printf("{\"omega\": %.17g", curve.omega(*curve.here()) * scales.frequency);
    print_values("coefficients",
                 coefficients_of(curve.motion(*curve.here(), instants_for(study.harmonics)), study.harmonics), model,
                 scales);
    found = curve.step();
  }
}

void run(const Wish &wish) {
  const Case study = read_case(wish.file, {});
  HarmonicSystem system = harmonic_system(study);
  if (!wish.from.empty()) check_start(wish.from, dense_model(system).dofs());
  wish.along > 0 ? follow(wish, study, system) : integrate(wish, study, system);
}

} // namespace
} // namespace dovetail

int main(int argc, char **argv) {
  const std::vector<std::string> words(argv + 1, argv + argc);
  int petsc_argc = 1;
  dovetail::order_the_same_way();
  if (SlepcInitialize(&petsc_argc, &argv, nullptr, nullptr)) return 3;
  dovetail::install_error_handler();
  int status = 0;
  try {
    dovetail::run(dovetail::parse(words));
  } catch (const dovetail::InputError &error) {
    status = 2, std::fprintf(stderr, "integrate: %s\n", error.what());
  } catch (const std::exception &error) {
    status = 3, std::fprintf(stderr, "integrate: %s\n", error.what());
  }
  SlepcFinalize();
  return status;
}
