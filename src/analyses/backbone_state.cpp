#include "analyses/backbone_stepper.hpp"
#include "support/error.hpp"

namespace dovetail {
namespace {

constexpr const char *doing = "restoring a mode";

// Cosine and sine of the own dofs, in the places of the first harmonic in y.
void archive_shape(Archive &archive, SavedVectors &vectors, const Layout &layout, Vec y, std::vector<double> &shape) {
  const auto exchange = [&](bool into) {
    double *own;
    check(VecGetArray(y, &own), doing);
    for (std::size_t i = 0; i < shape.size(); ++i) {
      double &place = own[i / 2 * layout.width + (i % 2 ? sine(1) : cosine(1))];
      (into ? place : shape[i]) = into ? shape[i] : place;
    }
    check(VecRestoreArray(y, &own), doing);
  };
  if (!archive.restores()) exchange(true);
  vectors.field(archive, "reference", y);
  if (archive.restores()) exchange(false);
}

} // namespace

BranchState Backbone::state() {
  const Layout &layout = mode_.system().layout();
  BranchState state;
  state.harmonics = mode_.system().harmonics(), state.samples = mode_.system().samples();
  SavedVectors vectors(layout);
  vectors.add(here_.y), vectors.add(here_.t);
  Archive brought, saved;
  archive(brought, vectors);
  vectors.bring();
  state.y = vectors.take(), state.tangent = vectors.take();
  state.counts = summary_.counts;
  state.counts.newton = counts_.newton, state.counts.linear = counts_.linear, state.counts.inexact = counts_.inexact;
  archive(saved, vectors);
  state.fields = saved.fields();
  return state;
}

void Backbone::restore(const BranchState &state) {
  const Layout &layout = mode_.system().layout();
  set_numbers(layout, state.y, here_.y);
  set_numbers(layout, state.tangent, here_.t);
  here_.parameter = parameter_of(here_.y);
  summary_.counts = state.counts;
  static_cast<SolveCounts &>(counts_) = state.counts;
  Archive saved(state.fields);
  SavedVectors vectors(layout);
  archive(saved, vectors);
}

// Saved and restored by the same list.
void Backbone::archive(Archive &archive, SavedVectors &vectors) {
  const Layout &layout = mode_.system().layout();
  archive.field("straight", straight_);
  archive.field("at_force", at_force_);
  archive.field("arclength", arclength_);
  archive.field("load", load_);
  archive.field("least", least_);
  archive.field("farthest_parameter", farthest_);
  archive.part("stepper", [&] { archive_steps(archive); });

  std::vector<double> reference = mode_.reference();
  archive_shape(archive, vectors, layout, mode_.unknowns(), reference);
  if (archive.restores()) mode_.refer_to(std::move(reference));

  double largest = curve_->norm.largest_motion();
  archive.field("largest_motion", largest);
  if (archive.restores()) { // the metric sees a vector that is so long
    const UniqueVec seen = mode_.unknowns();
    if (layout.rank == 0) check(VecSetValue(seen, 0, largest, INSERT_VALUES), doing);
    check(VecAssemblyBegin(seen), doing);
    check(VecAssemblyEnd(seen), doing);
    curve_->norm.see(seen);
  }
  vectors.point(archive, "before", *curve_, before_);
  vectors.ahead(archive, *curve_, ahead_, [](CurvePoint &) {});
  archive_memory(archive, *curve_);
  if (observer_.archive) observer_.archive(archive);
}

} // namespace dovetail
