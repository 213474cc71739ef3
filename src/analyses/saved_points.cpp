#include "analyses/saved_points.hpp"

#include <algorithm>
#include <string>

#include "harmonic/dense_model.hpp"
#include "support/error.hpp"

namespace dovetail {

void set_numbers(const Layout &layout, std::vector<double> numbers, Vec y) {
  constexpr const char *doing = "restoring a state";
  const auto behind = numbers.begin() + layout.dofs() * layout.width;
  double *own;
  check(VecGetArray(y, &own), doing);
  if (layout.owns_omega()) std::copy(behind, numbers.end(), own + layout.own_coefficients());
  check(VecRestoreArray(y, &own), doing);
  numbers.erase(behind, numbers.end());
  set_coefficients(layout, numbers, y);
}

void SavedVectors::add(Vec y) { all_.add(y); }

void SavedVectors::bring() {
  all_.bring();
  brought_ = true;
}

void archive_memory(Archive &archive, Curve &curve) {
  double memory = curve.memory();
  archive.field("solver_memory", memory);
  if (archive.restores()) curve.recall(memory);
}

void SavedVectors::field(Archive &archive, const char *name, Vec y) {
  if (!archive.restores() && !brought_) return add(y);
  std::vector<double> numbers;
  if (!archive.restores()) numbers = take();
  archive.field(name, numbers);
  if (archive.restores()) set_numbers(layout_, std::move(numbers), y);
}

void SavedVectors::metric(Archive &archive, ResponseMetric &metric) {
  double motion = metric.largest_motion();
  std::vector<double> own = metric.largest_of_dofs(), all;
  if (!archive.restores() && !brought_) return all_.add_dofs(own);
  if (!archive.restores()) all = take();
  archive.field("largest_motion", motion);
  archive.field("largest_of_dofs", all);
  if (!archive.restores()) return;
  for (std::size_t d = 0; d < own.size(); ++d) own[d] = all.at(layout_.number(static_cast<PetscInt>(d)));
  metric.restore(motion, std::move(own));
}

void SavedVectors::known_point(Archive &archive, CurvePoint &point) {
  archive.field("sign", point.sign);
  field(archive, "y", point.y);
  field(archive, "t", point.t);
  if (archive.restores()) point.parameter = parameter_of(point.y);
}

void SavedVectors::point(Archive &archive, const char *name, const Curve &curve, std::optional<CurvePoint> &point) {
  archive.part(name, [&] {
    bool known = point.has_value();
    archive.field("known", known);
    if (!known) return;
    if (archive.restores()) point = curve.point();
    known_point(archive, *point);
  });
}

void SavedVectors::ahead(Archive &archive, const Curve &curve, std::vector<CurvePoint> &points,
                         const std::function<void(CurvePoint &)> &describe) {
  int count = static_cast<int>(points.size());
  archive.field("ahead", count);
  for (int i = 0; i < count; ++i)
    archive.part(("ahead_" + std::to_string(i)).c_str(), [&] {
      if (archive.restores()) points.push_back(curve.point());
      CurvePoint &point = points[i];
      known_point(archive, point);
      archive.field("newton", point.newton.newton);
      archive.field("linear", point.newton.linear);
      archive.field("residual", point.newton.residual);
      if (archive.restores()) describe(point);
    });
}

} // namespace dovetail
