// Any bytes as a case file, and what is made of the case before the model is read.
#include <sstream>

#include "app/forecast.hpp"
#include "case/case.hpp"
#include "harness.hpp"

using namespace dovetail;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t *data, std::size_t size) {
  static const fuzz::Scratch folder;
  static const bool ready = [] {
    for (const char *name : {"model.h5", "reduced.h5", "start.h5"}) fuzz::write(folder / name, "x", 1);
    return true;
  }();
  (void)ready;
  const auto file = folder / "case.toml";
  fuzz::write(file, data, size);
  Case study;
  if (!fuzz::taken(file, [&] { study = read_case(file, {}); })) return 0;
  for (const int points : {1, 2, 3})
    fuzz::taken(file, [&] {
      const Forecast sizes = forecast(ReducedHeader{2, points, {"force"}}, study);
      const auto contact = contact_points(study.contact, {}, points);
      initial_preload(study, points);
      std::ostringstream out;
      describe(out, study, contact, {});
      describe(out, sizes);
    });
  return 0;
}
