#pragma once
// The excitation: patterns of force, each with its own course over the period.
#include <cstddef>
#include <vector>

namespace dovetail {

/// One pattern F_j with its course f_j(t).
struct LoadCase {
  std::vector<double> vector;  ///< F_j by dof, scaled
  std::vector<double> fourier; ///< f_j(t) as [a0, a1, b1, ...]
};

/// Coefficient `place` of [a0, a1, b1, ...] of the force on a dof: sum over the loads of factor F_j f_j.
inline double force_coefficient(const std::vector<LoadCase> &loads, std::size_t dof, std::size_t place,
                                double factor = 1) {
  double sum = -0.0; // what adds nothing, not even to the sign of a zero
  for (const LoadCase &load : loads)
    if (place < load.fourier.size()) sum += factor * load.vector[dof] * load.fourier[place];
  return sum;
}

/// The highest harmonic of any load, 0 if all are constant.
inline int highest_harmonic(const std::vector<LoadCase> &loads) {
  std::size_t highest = 0;
  for (const LoadCase &load : loads)
    for (std::size_t place = 0; place < load.fourier.size(); ++place)
      if (load.fourier[place] != 0 && (place + 1) / 2 > highest) highest = (place + 1) / 2;
  return static_cast<int>(highest);
}

} // namespace dovetail
