#include "app/watching.hpp"

#include <algorithm>
#include <cmath>

namespace dovetail {
namespace {

// Of an amplitude: unknowns that differ by less move alike, as by symmetry. The first of them is named, on any
// processor.
constexpr double alike = 1e-6;

double size_of(const double *c, int harmonics) {
  double sum = 0;
  for (int k = 1; k <= harmonics; ++k) sum += c[cosine(k)] * c[cosine(k)] + c[sine(k)] * c[sine(k)];
  return std::sqrt(sum);
}

} // namespace

Watching::Watching(const Case &study, const HarmonicSystem &system)
    : study_(study), system_(system), units_(units_of(system.scaled().model.reduced.units)),
      dof_(watched_dof(study, static_cast<int>(system.layout().modes), static_cast<int>(system.layout().points))) {
  const ReducedModel &reduced = system.scaled().model.reduced;
  if (!study.watch.node.empty())
    row_ = reduced.watched_by_index.empty() ? WatchedRow(reduced.watched)
                                            : WatchedRow(reduced.watched_by_index, system.wave());
}

double Watching::unit() const {
  const bool modal = shown() >= 0 && shown() < system_.layout().modes;
  return modal ? system_.scales().modal : system_.scales().contact;
}

int Watching::shown() const {
  const bool any_mode = study_.watch.node.empty() && dof_ < 0 && system_.layout().points == 0;
  return any_mode ? 0 : static_cast<int>(dof_);
}

Watched Watching::scaled() const {
  if (!row_) return {dof_, {}};
  WatchedRow row = *row_;
  const Scales &scales = system_.scales();
  for (PetscInt i = 0; i < system_.layout().modes; ++i) row.scale(i, scales.modal / scales.contact);
  return {-1, std::move(row)};
}

void Watching::measure(PointRecord &point) {
  const int width = coefficient_count(point.harmonics);
  const auto dofs = static_cast<PetscInt>(point.coefficients.size()) / width, modes = system_.layout().modes;
  if (!swing_ || harmonics_ != point.harmonics) swing_.emplace(harmonics_ = point.harmonics);
  if (row_) {
    std::vector<double> sum(width, 0.0);
    for (PetscInt d = 0; d < dofs; ++d) row_->add(d, &point.coefficients[d * width], width, sum.data());
    point.amplitude = swing_->amplitude(sum.data()), point.tracked = size_of(sum.data(), point.harmonics);
    point.unknown = -1;
    return;
  }
  point.amplitude = -1;
  for (PetscInt d = dof_ >= 0 ? dof_ : modes < dofs ? modes : 0; d < (dof_ >= 0 ? dof_ + 1 : dofs); ++d) {
    const double *c = &point.coefficients[d * width];
    double bound = 0;
    for (int k = 1; k <= point.harmonics; ++k) bound += std::hypot(c[cosine(k)], c[sine(k)]);
    if (bound <= point.amplitude) continue;
    const double here = swing_->amplitude(c);
    if (here > point.amplitude * (1 + alike))
      point.tracked = size_of(c, point.harmonics), point.unknown = static_cast<int>(d);
    point.amplitude = std::max(point.amplitude, here);
  }
}

} // namespace dovetail
