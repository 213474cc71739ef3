#include "harmonic/gathering.hpp"

#include "support/error.hpp"
#include "support/gathered.hpp"
#include "support/shell.hpp"

namespace dovetail {

void Gathering::add(Vec y) {
  const ReadValues values(y);
  PetscInt all, own;
  check(VecGetSize(y, &all), "collecting coefficients");
  check(VecGetLocalSize(y, &own), "collecting coefficients");
  kinds_.push_back({layout_.width, 3 * layout_.width, all - layout_.dofs() * layout_.width});
  own_.insert(own_.end(), values + 0, values + own);
}

void Gathering::add_dofs(const std::vector<double> &own) {
  kinds_.push_back({1, 3, 0});
  own_.insert(own_.end(), own.begin(), own.end());
}

void Gathering::add_points(const std::vector<double> &own, int each) {
  kinds_.push_back({0, each, 0});
  own_.insert(own_.end(), own.begin(), own.end());
}

void Gathering::bring() {
  if (layout_.size == 1) {
    all_ = std::move(own_);
    return;
  }
  std::vector<long long> all_counts(layout_.size);
  for (int r = 0; r < layout_.size; ++r)
    for (const Kind &kind : kinds_)
      all_counts[r] += share_of(layout_.modes, r, layout_.size).size() * kind.mode +
                       share_of(layout_.points, r, layout_.size).size() * kind.point +
                       (r == layout_.size - 1 ? kind.last : 0);
  const std::vector<int> places = places_of(all_counts), counts(all_counts.begin(), all_counts.end());
  if (layout_.rank == 0) all_.resize(places.back());
  MPI_Gatherv(own_.data(), counts[layout_.rank], MPI_DOUBLE, all_.data(), counts.data(), places.data(), MPI_DOUBLE, 0,
              layout_.comm);
}

std::vector<double> Gathering::take(std::size_t number) const {
  std::vector<double> modes, points;
  auto from = all_.begin();
  for (int r = 0; r < layout_.size && layout_.rank == 0; ++r)
    for (std::size_t i = 0; i < kinds_.size(); ++i) {
      const auto after_modes = from + share_of(layout_.modes, r, layout_.size).size() * kinds_[i].mode,
                 after = after_modes + share_of(layout_.points, r, layout_.size).size() * kinds_[i].point +
                         (r == layout_.size - 1 ? kinds_[i].last : 0);
      if (i == number) modes.insert(modes.end(), from, after_modes), points.insert(points.end(), after_modes, after);
      from = after;
    }
  modes.insert(modes.end(), points.begin(), points.end());
  return modes;
}

} // namespace dovetail
