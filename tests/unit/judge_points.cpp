// The stability of every point of a results file, judged anew:   judge_points CASE.toml RESULTS.h5
// One line of JSON per point on stdout, after whatever the reduction says.
#include <slepc.h>

#include <cmath>
#include <cstdio>
#include <ctime>

#include "app/reduce.hpp"
#include "contact/fourier.hpp"
#include "harmonic/dense_model.hpp"
#include "stability/stability.hpp"
#include "support/error.hpp"
#include "support/hdf5.hpp"

using namespace dovetail;

namespace {

void print(const char *name, double value) {
  if (std::isfinite(value))
    std::printf(", \"%s\": %.10g", name, value);
  else
    std::printf(", \"%s\": null", name);
}

void judge_points(const std::filesystem::path &file, const std::filesystem::path &results) {
  const Case study = read_case(file, results.parent_path());
  const Voice voice(PETSC_COMM_WORLD);
  Stages stages;
  std::optional<ReductionFigures> figures;
  ReducedModel reduced =
      reduced_model(PETSC_COMM_WORLD, study, results.parent_path() / "reduced.h5", stages, voice, figures);
  const int points = static_cast<int>(reduced.points), modes = static_cast<int>(reduced.modes);
  ContactSettings from_model;
  if (study.reduced.empty())
    from_model = read_model_header(study.model).contact;
  else
    from_model.area = read_reduced_header(study.reduced).area;
  const std::vector<ContactPoint> contact = contact_points(study.contact, from_model, points);
  std::string note;
  PreloadedModel preloaded = contact_preload(std::move(reduced), contact, initial_preload(study, points), note);
  const Scales scales = choose_scales(study, preloaded);

  const h5::Reader reader(results);
  const auto shape = reader.extent("/points/coefficients");
  const std::vector<double> omega = reader.doubles("/points/omega");
  const HarmonicSystem system(scaled(std::move(preloaded), study.damping, scales), static_cast<int>(shape[2]) / 2,
                              exactly, study.loads);
  StabilityTest test(dense_model(system));
  for (hsize_t i = 0; i < shape[0]; ++i) {
    std::vector<double> q = reader.doubles("/points/coefficients", {i, 0, 0}, {1, shape[1], shape[2]});
    for (std::size_t k = 0; k < q.size(); ++k)
      q[k] /= k / shape[2] < static_cast<hsize_t>(modes) ? scales.modal : scales.contact;
    const std::clock_t begin = std::clock();
    const Stability s = test.judge(q, omega[i] / scales.frequency);
    const double seconds = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC; // of this processor
    std::printf("{\"omega\": %.17g, \"stable\": %d, \"kind\": %d", omega[i], static_cast<int>(s.verdict),
                static_cast<int>(s.kind));
    print("multiplier", s.multiplier), print("growth", s.growth);
    print("by_monodromy", test.opinions().by_monodromy), print("doubt", test.opinions().doubt);
    print("by_hill", test.opinions().by_hill), print("seconds", seconds);
    std::printf("}\n");
  }
}

} // namespace

int main(int argc, char **argv) {
  SlepcInitialize(&argc, &argv, nullptr, nullptr);
  install_error_handler();
  int status = 2;
  try {
    if (argc == 3) judge_points(argv[1], argv[2]), status = 0;
  } catch (const std::exception &error) {
    std::fprintf(stderr, "%s\n", error.what());
  }
  SlepcFinalize();
  return status;
}
