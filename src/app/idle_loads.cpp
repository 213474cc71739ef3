#include "app/idle_loads.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include "support/error.hpp"

namespace dovetail {
namespace {

// Rounding errors of a sum, by the sizes of its parts: some fifty roundings, and those of products with all modes.
constexpr double of_forces = 1e-14, of_reduced = 1e-12;

// Of the load patterns of a file, each times its factor, the sum: its largest entry over all ranks.
using Sum = std::function<double(const std::vector<double> &factors)>;

// The largest entry of each pattern.
std::vector<double> sizes(const Sum &sum, std::size_t patterns) {
  std::vector<double> found;
  for (std::size_t j = 0; j < patterns; ++j) {
    std::vector<double> factors(patterns);
    factors[j] = 1;
    found.push_back(sum(factors));
  }
  return found;
}

// Coefficients of the case at a place of [a0, a1, b1, ...], for each pattern.
std::vector<double> factors_at(std::size_t place, const Case &study, const std::vector<std::string> &patterns) {
  std::vector<double> factors;
  for (const std::string &name : patterns) {
    const auto load = std::find_if(study.loads.begin(), study.loads.end(),
                                   [&name](const LoadCourse &course) { return course.pattern == name; });
    factors.push_back(load == study.loads.end() ? 0 : load->fourier[place]);
  }
  return factors;
}

bool is_varying(const LoadCourse &load) {
  return std::any_of(load.fourier.begin() + 1, load.fourier.end(), [](double value) { return value != 0; });
}

// `sums`: one for each kind of entry, as their units differ. Where no load is to vary the structure rests, and may.
void refuse(const Case &study, const std::filesystem::path &file, const std::vector<std::string> &patterns,
            const std::vector<Sum> &sums, double rounding) {
  bool any = false, varies = false;
  for (const Sum &sum : sums) {
    const std::vector<double> size = sizes(sum, patterns.size());
    for (std::size_t place = 0; place < study.loads[0].fourier.size(); ++place) {
      const std::vector<double> factors = factors_at(place, study, patterns);
      double apart = 0;
      for (std::size_t j = 0; j < factors.size(); ++j) apart += std::abs(factors[j]) * size[j];
      any = any || apart > 0;
      if (place == 0 || apart == 0) continue;
      if (sum(factors) > rounding * apart) return;
      varies = true;
    }
  }
  const auto place = [&](const LoadCourse &load) { return load.where + ": of " + file.string() + " "; };
  if (varies)
    throw InputError(place(study.loads[0]) +
                     "all load patterns together, each times its course, add up to no force that "
                     "varies, nothing would vibrate; change one of them");
  if (any && std::none_of(study.loads.begin(), study.loads.end(), is_varying)) return;
  std::string names, first;
  for (const LoadCourse &load : study.loads) {
    if (any && !is_varying(load)) continue;
    if (names.empty()) first = place(load);
    names += (names.empty() ? "\"" : ", \"") + load.pattern + '"';
  }
  throw InputError(first + "the load pattern " + names + " has no force other than zero, nothing would " +
                   (any ? "vibrate" : "move") + "; write forces there, or name another pattern");
}

// Of vectors of the reduced model: `vector` of each load.
template <class Vector> Sum sum_of(MPI_Comm comm, const Vector &vector) {
  return [comm, vector](const std::vector<double> &factors) {
    double largest = 0;
    for (std::size_t i = 0; i < vector(0).size(); ++i) {
      auto sum = factors[0] * vector(0)[i];
      for (std::size_t j = 1; j < factors.size(); ++j) sum += factors[j] * vector(j)[i];
      largest = std::max(largest, std::abs(sum));
    }
    MPI_Allreduce(MPI_IN_PLACE, &largest, 1, MPI_DOUBLE, MPI_MAX, comm);
    return largest;
  };
}

} // namespace

void refuse_idle_loads(const Case &study, const FullModel &model) {
  constexpr const char *doing = "looking at the loads";
  UniqueVec all;
  check(VecDuplicate(model.preload, all.out()), doing);
  std::vector<std::string> names;
  for (const ForcePattern &pattern : model.forces) names.push_back(pattern.name);
  const Sum sum = [&](const std::vector<double> &factors) {
    check(VecSet(all, 0), doing);
    for (std::size_t j = 0; j < factors.size(); ++j) check(VecAXPY(all, factors[j], model.forces[j].values), doing);
    PetscReal norm;
    check(VecNorm(all, NORM_INFINITY, &norm), doing);
    return norm;
  };
  refuse(study, model.file, names, {sum}, of_forces);
}

void refuse_idle_loads(const Case &study, const ReducedModel &model) {
  std::vector<std::string> names;
  for (const LoadPattern &pattern : model.loads) names.push_back(pattern.name);
  std::vector<Sum> sums;
  const auto add = [&](const auto &loads) {
    sums.push_back(sum_of(
        model.comm, [&loads](std::size_t j) -> const auto & { return loads[j].fa; }));
    sums.push_back(sum_of(
        model.comm, [&loads](std::size_t j) -> const auto & { return loads[j].fx; }));
  };
  add(model.loads);
  for (const SectorIndex &index : model.indices) add(index.loads);
  refuse(study, study.reduced, names, sums, of_reduced);
}

} // namespace dovetail
