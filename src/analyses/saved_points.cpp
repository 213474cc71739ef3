#include "analyses/saved_points.hpp"

#include <algorithm>
#include <string>

#include "harmonic/dense_model.hpp"
#include "support/error.hpp"

namespace dovetail {
namespace {

constexpr const char *doing = "saving a state";

void archive_point(Archive &archive, const Layout &layout, CurvePoint &point) {
  archive.field("sign", point.sign);
  archive_vector(archive, "y", layout, point.y);
  archive_vector(archive, "t", layout, point.t);
  point.parameter = parameter_of(point.y);
}

} // namespace

std::vector<double> numbers_of(const Layout &layout, Vec y) {
  std::vector<double> numbers = all_coefficients(layout, y);
  PetscInt all;
  check(VecGetSize(y, &all), doing);
  std::vector<double> behind(all - layout.dofs() * layout.width);
  const double *own;
  check(VecGetArrayRead(y, &own), doing);
  if (layout.owns_omega()) std::copy_n(own + layout.own_coefficients(), behind.size(), behind.begin());
  check(VecRestoreArrayRead(y, &own), doing);
  MPI_Bcast(behind.data(), static_cast<int>(behind.size()), MPI_DOUBLE, layout.size - 1, layout.comm);
  numbers.insert(numbers.end(), behind.begin(), behind.end());
  return numbers;
}

void set_numbers(const Layout &layout, std::vector<double> numbers, Vec y) {
  const auto behind = numbers.begin() + layout.dofs() * layout.width;
  double *own;
  check(VecGetArray(y, &own), doing);
  if (layout.owns_omega()) std::copy(behind, numbers.end(), own + layout.own_coefficients());
  check(VecRestoreArray(y, &own), doing);
  numbers.erase(behind, numbers.end());
  set_coefficients(layout, numbers, y);
}

void archive_vector(Archive &archive, const char *name, const Layout &layout, Vec y) {
  std::vector<double> numbers;
  if (!archive.restores()) numbers = numbers_of(layout, y);
  archive.field(name, numbers);
  if (archive.restores()) set_numbers(layout, std::move(numbers), y);
}

// Both by the number of the dof, on every rank.
void archive_metric(Archive &archive, const Layout &layout, ResponseMetric &metric) {
  double motion = metric.largest_motion();
  std::vector<double> own = metric.largest_of_dofs(), all(layout.dofs(), 0.0);
  for (std::size_t d = 0; d < own.size(); ++d) all[layout.number(static_cast<PetscInt>(d))] = own[d];
  MPI_Allreduce(MPI_IN_PLACE, all.data(), static_cast<int>(all.size()), MPI_DOUBLE, MPI_SUM, layout.comm);
  archive.field("largest_motion", motion);
  archive.field("largest_of_dofs", all);
  if (!archive.restores()) return;
  for (std::size_t d = 0; d < own.size(); ++d) own[d] = all.at(layout.number(static_cast<PetscInt>(d)));
  metric.restore(motion, std::move(own));
}

void archive_memory(Archive &archive, Curve &curve) {
  double memory = curve.memory();
  archive.field("solver_memory", memory);
  if (archive.restores()) curve.recall(memory);
}

void archive_point(Archive &archive, const char *name, const Layout &layout, const Curve &curve,
                   std::optional<CurvePoint> &point) {
  archive.part(name, [&] {
    bool known = point.has_value();
    archive.field("known", known);
    if (!known) return;
    if (archive.restores()) point = curve.point();
    archive_point(archive, layout, *point);
  });
}

void archive_ahead(Archive &archive, const Layout &layout, const Curve &curve, std::vector<CurvePoint> &ahead,
                   const std::function<void(CurvePoint &)> &describe) {
  int count = static_cast<int>(ahead.size());
  archive.field("ahead", count);
  for (int i = 0; i < count; ++i)
    archive.part(("ahead_" + std::to_string(i)).c_str(), [&] {
      if (archive.restores()) ahead.push_back(curve.point());
      CurvePoint &point = ahead[i];
      archive_point(archive, layout, point);
      archive.field("newton", point.newton.newton);
      archive.field("linear", point.newton.linear);
      archive.field("residual", point.newton.residual);
      if (archive.restores()) describe(point);
    });
}

} // namespace dovetail
