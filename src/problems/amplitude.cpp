#include "problems/amplitude.hpp"

#include <algorithm>
#include <cmath>

#include "support/error.hpp"

namespace dovetail {
namespace {

struct Moment { // the deviation from the mean and its first two derivatives by theta
  double value, slope, bend;
};

Moment at(const double *c, int harmonics, double theta) {
  Moment m{};
  for (int k = 1; k <= harmonics; ++k) {
    const double a = c[cosine(k)], b = c[sine(k)], cos = std::cos(k * theta), sin = std::sin(k * theta);
    m.value += a * cos + b * sin, m.slope += k * (b * cos - a * sin), m.bend -= k * k * (a * cos + b * sin);
  }
  return m;
}

} // namespace

AmplitudeMeter::AmplitudeMeter(const Layout &layout, PetscInt watched)
    : layout_(layout), watched_(watched), harmonics_((layout.width - 1) / 2), values_(std::max(64, 8 * harmonics_)),
      slopes_(values_.size()), grid_(harmonics_, static_cast<int>(values_.size())) {}

// Instant at which |q - mean| is largest: the best of a grid, then Newton on the derivative within a grid step.
double AmplitudeMeter::extreme(const double *c) {
  grid_.sample(c, values_.data(), slopes_.data());
  const double mean = c[0] / 2;
  const auto far = [&](double a, double b) { return std::abs(a - mean) < std::abs(b - mean); };
  const auto best = std::max_element(values_.begin(), values_.end(), far) - values_.begin();
  const double step = 2 * M_PI / values_.size(), first = best * step;
  double theta = first;
  for (int i = 0; i < 20; ++i) {
    const Moment m = at(c, harmonics_, theta);
    if (m.bend == 0 || m.value * m.bend > 0) break; // not round this top
    const double next = theta - m.slope / m.bend;
    if (std::abs(next - first) > step) break;
    const bool done = std::abs(next - theta) < 1e-14;
    theta = next;
    if (done) break;
  }
  return theta;
}

Amplitude AmplitudeMeter::operator()(Vec y, Vec t) {
  struct {
    double value;
    int rank;
  } most{-1, layout_.rank};
  double slope = 0;
  const double *q, *u;
  check(VecGetArrayRead(y, &q), "measuring an amplitude");
  check(VecGetArrayRead(t, &u), "measuring an amplitude");
  for (PetscInt d = 0; d < layout_.own_dofs(); ++d) {
    const bool mode = d < layout_.own_modes.size();
    if (watched_ >= 0 ? layout_.number(d) != watched_ : mode && layout_.points > 0) continue;
    const double *c = q + d * layout_.width, *along = u + d * layout_.width;
    double bound = 0;
    for (int i = 1; i < layout_.width; ++i) bound += std::abs(c[i]);
    if (bound <= most.value) continue;
    const double theta = extreme(c), moved = at(c, harmonics_, theta).value;
    if (std::abs(moved) <= most.value) continue;
    most.value = std::abs(moved);
    slope =
        std::copysign(1.0, moved) * at(along, harmonics_, theta).value; // theta itself does not matter at an extreme
  }
  check(VecRestoreArrayRead(t, &u), "measuring an amplitude");
  check(VecRestoreArrayRead(y, &q), "measuring an amplitude");
  MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPI_DOUBLE_INT, MPI_MAXLOC, layout_.comm);
  MPI_Bcast(&slope, 1, MPI_DOUBLE, most.rank, layout_.comm);
  return {std::max(most.value, 0.0), slope};
}

} // namespace dovetail
