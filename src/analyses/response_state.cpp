// Where the curve stands, by the names of its fields, and back.
#include <utility>

#include "analyses/response_stepper.hpp"
#include "harmonic/gathering.hpp"
#include "support/error.hpp"

namespace dovetail {
namespace {

void set_numbers(const HarmonicSystem &system, std::vector<double> numbers, Vec y) {
  const double last = numbers.back();
  numbers.pop_back();
  set_coefficients(system.layout(), numbers, y);
  set_parameter(y, last);
}

} // namespace

// Vectors on their way into a file, or back: those that are saved are brought to rank 0 by one message.
class ResponseStepper::Vectors {
public:
  explicit Vectors(const HarmonicSystem &system) : system_(system), all_(system.layout()) {}

  void add(const CurvePoint &point) { all_.add(point.y), all_.add(point.t), count_ += 2; }
  std::size_t add_dofs(const std::vector<double> &own) {
    all_.add_dofs(own);
    return count_++;
  }
  void bring() { all_.bring(); }
  std::vector<double> take(std::size_t number) const { return all_.take(number); }
  std::vector<double> take() { return all_.take(next_++); }

  // In the order in which they were added.
  void archive(Archive &archive, CurvePoint &point) {
    archive.field("sign", point.sign);
    for (const auto &[name, y] : {std::pair("y", Vec(point.y)), std::pair("t", Vec(point.t))}) {
      std::vector<double> numbers;
      if (!archive.restores()) numbers = take();
      archive.field(name, numbers);
      if (archive.restores()) set_numbers(system_, std::move(numbers), y);
    }
    if (archive.restores()) point.parameter = system_.parameter_in(point.y);
  }

private:
  const HarmonicSystem &system_;
  Gathering all_;
  std::size_t count_ = 0, next_ = 0;
};

// What needs no layout. Saved and restored by the same list.
void ResponseStepper::archive(Archive &archive) {
  range.archive(archive);
  archive.field("arclength", arclength_);
  amplitude_.archive(archive);
  stability_.archive(archive);
  harmonics_.archive(archive);
  errors.archive(archive);
  archive.part("stepper", [&] { archive_steps(archive); });
  progress.archive(archive);

  double memory = curve_->memory();
  archive.field("solver_memory", memory);
  if (archive.restores()) curve_->recall(memory);
}

// Points that are gone back to or guessed by, without what belongs to the solve; and those that are to be given.
void ResponseStepper::archive_points(Archive &archive, Vectors &vectors) {
  const std::pair<const char *, std::optional<CurvePoint> *> points[] = {{"before", &before_},
                                                                         {"farthest", &farthest.point}};
  for (const auto &[name, point] : points)
    archive.part(name, [&, place = point] {
      bool known = place->has_value();
      archive.field("known", known);
      if (!known) return;
      if (archive.restores()) *place = curve_->point();
      vectors.archive(archive, **place);
    });
  int count = static_cast<int>(ahead_.size());
  archive.field("ahead", count);
  for (int i = 0; i < count; ++i)
    archive.part(("ahead_" + std::to_string(i)).c_str(), [&] {
      if (archive.restores()) ahead_.push_back(curve_->point());
      CurvePoint &point = ahead_[i];
      vectors.archive(archive, point);
      archive.field("newton", point.newton.newton);
      archive.field("linear", point.newton.linear);
      archive.field("residual", point.newton.residual);
      if (archive.restores()) describe(point);
    });
}

// What belongs to a solve.
void ResponseStepper::describe(CurvePoint &point) {
  const UniqueVec r = response.system().unknowns();
  response.system().residual(point.y, r);
  point.data = curve_->problem.describe();
}

void ResponseStepper::save(BranchState &state, Archive &saved) {
  const HarmonicSystem &system = response.system();
  state.harmonics = system.harmonics(), state.samples = system.samples();
  Vectors vectors(system);
  vectors.add(here_);
  for (const auto *point : {&before_, &farthest.point})
    if (*point) vectors.add(**point);
  for (const CurvePoint &point : ahead_) vectors.add(point);
  const std::size_t largest = vectors.add_dofs(response.metric().largest_of_dofs());
  vectors.bring();
  state.y = vectors.take(), state.tangent = vectors.take();
  if (!state.y.empty()) state.y.back() = here_.parameter;
  state.largest = vectors.take(largest);
  archive(saved);
  archive_points(saved, vectors);
  saved.note("largest_motion", curve_->norm.largest_motion());
  state.trail = progress.retraced.marks();
}

void ResponseStepper::restore(const BranchState &state, Archive &saved) {
  const HarmonicSystem &given = response.system();
  if (state.harmonics != given.harmonics() || state.samples != given.samples())
    adopt(std::make_unique<HarmonicSystem>(given, state.harmonics, state.samples));
  HarmonicSystem &system = response.system();
  set_numbers(system, state.y, here_.y);
  set_numbers(system, state.tangent, here_.t);
  here_.parameter = state.y.back();
  std::vector<double> largest;
  for (PetscInt d = 0; d < system.layout().own_dofs(); ++d)
    largest.push_back(state.largest.at(system.layout().number(d)));
  double motion = 0;
  saved.field("largest_motion", motion);
  response.metric().restore(motion, std::move(largest));
  archive(saved);
  Vectors vectors(system);
  archive_points(saved, vectors);
  progress.retraced.restore(state.trail);
  describe(here_);
  stability_.stand(stability_.judge(here_));
}

} // namespace dovetail
