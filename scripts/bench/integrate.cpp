// Steady states of a case by time integration, the truth that harmonic balance is measured against.
//
//   build/integrate CASE.toml omega [omega ...] [--from results.h5] [--amplitude] [--periods 2000] [--tolerance 1e-6]
//                                               [--work 2e10] [--harmonics N]
//
// On one rank. Reads the case, reduces the model or reads the reduced one, finds the preload state and integrates at
// each frequency [rad/s]: from rest there, or with --from from the point of that file nearest to it, so that it stays
// on that branch. --harmonics: of what is printed, the case's unless given. --periods and --work (multiplications)
// bound what one frequency may take. Prints one line of JSON for each: omega, settled, periods, change (between the
// last two, relative), multiplier (null unless shooting found the motion; beyond 1 it is unstable), seconds, and in
// user units, modes first, then t1, t2, n of each contact point, `coefficients` (n, 2H+1), or with --amplitude the
// largest |q - mean| over the cycle (n), from its course in time. Both are null where the numbers ran away or the work
// was used up.
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
#include "transient/start.hpp"
#include "transient/steady_state.hpp"

namespace dovetail {
namespace {

struct Wish {
  std::filesystem::path file, from;
  std::vector<double> omegas;
  bool amplitude = false;
  int harmonics = 0;
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
    else if (words[i] == "--harmonics")
      wish.harmonics = std::stoi(next());
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
  if (wish.omegas.empty()) throw InputError("wanted: CASE.toml and frequencies; see the head of integrate.cpp");
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

// Scaled, from the point of the file nearest to that frequency.
MotionState start_of(const Wish &wish, double omega, HarmonicSystem &system, const DenseModel &model) {
  const UniqueVec y = system.unknowns();
  start_from(wish.from, omega, system.layout(), system.scales(), y);
  const Flow flow(model, omega / system.scales().frequency);
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

void run(const Wish &wish) {
  const Case study = read_case(wish.file, {});
  HarmonicSystem system = harmonic_system(study);
  if (!wish.from.empty()) check_start(wish.from, dense_model(system).dofs(), {});
  integrate(wish, study, system);
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
