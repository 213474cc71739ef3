#include "modal/contact_factors.hpp"

#include <petscsys.h>
// needs the one above
#include <petscblaslapack.h>

#include <algorithm>
#include <numeric>
#include <utility>

namespace dovetail {

void ContactFactors::list_moving(const ContactDerivative &contact, bool all) {
  moving_.clear();
  for (int p = 0; p < contact.size(); ++p) {
    const auto springs = stuck_springs(contact.points()[p]);
    if (!all && contact.springs_only(p) && std::equal(springs.begin(), springs.end(), &basis_.springs[3 * p])) continue;
    for (int d = has_friction(contact.points()[p].law) ? 0 : 2; d < 3; ++d) moving_.push_back(3 * p + d);
  }
}

void ContactFactors::look_at(const ContactDerivative &contact, bool all, std::optional<double> told) {
  list_moving(contact, all);
  count_moving(all ? std::nullopt : told);
}

double ContactFactors::own_moving(const ContactDerivative &contact) {
  list_moving(contact, false);
  return static_cast<double>(moving_.size());
}

// LAPACK reaches more than half of what a core can do, the products of gather and fill less.
double ContactFactors::work() const {
  const double rows = static_cast<double>(rows_), size = rows * layout_.width;
  return size * size * size + 100 * size * size + 6.0 * layout_.width * rows * rows * length() + 4e5;
}

double ContactFactors::work_to_solve() const {
  const double rows = static_cast<double>(rows_), size = rows * layout_.width, n = static_cast<double>(n_);
  return 12 * size * size + 8 * length() * layout_.width * (rows + n) + 1e5;
}

void ContactFactors::list_blocks() {
  points_ = 0, blocks_.clear();
  for (std::size_t first = 0, last; first < factored_.size(); first = last, ++points_) {
    for (last = first; last < factored_.size() && factored_[last] / 3 == factored_[first] / 3;) ++last;
    for (std::size_t row = first; row < last; ++row)
      for (std::size_t column = first; column < last; ++column) blocks_.push_back({row, column, true});
  }
}

// delta_ of all that move.
void ContactFactors::gather_deltas(const JacobianParts &parts) {
  const int w = layout_.width;
  const std::size_t size = static_cast<std::size_t>(w) * w;
  const auto owner = [&](const Block &block) {
    return owner_of(layout_.points, factored_[block.row] / 3, layout_.size);
  };
  std::vector<int> counts(layout_.size), starts(layout_.size);
  for (const Block &block : blocks_) counts[owner(block)] += static_cast<int>(size);
  std::exclusive_scan(counts.begin(), counts.end(), starts.begin(), 0);
  std::vector<double> own;
  std::vector<double> &kept = layout_.size == 1 ? delta_ : own;
  kept.resize(counts[layout_.rank]), written_.resize(9 * size);
  double *to = kept.data();
  PetscInt point = -1;
  for (const Block &block : blocks_) {
    if (owner(block) != layout_.rank) continue;
    const PetscInt p = factored_[block.row] / 3 - layout_.own_points.begin;
    const int row = static_cast<int>(factored_[block.row] % 3), column = static_cast<int>(factored_[block.column] % 3);
    const auto &places = parts.contact.places(static_cast<int>(p));
    if (std::exchange(point, p) != p) parts.contact.write(static_cast<int>(p), written_.data());
    const auto place = std::find_if(places.begin(), places.end(),
                                    [&](const BlockPlace &at) { return at.row == row && at.column == column; });
    if (place == places.end())
      std::fill_n(to, size, 0.0);
    else
      std::copy_n(&written_[(place - places.begin()) * size], size, to);
    const double spring = row == column ? basis_.springs[3 * p + row] : 0;
    if (row == column && parts.held) to[0] += parts.held[3 * p + row];
    for (int i = 0; i < w && spring != 0; ++i) {
      to[i * w + i] -= spring;
      const double cross = spring * structure_.loss((i + 1) / 2);
      if (i > 0) to[i * w + (i % 2 ? i + 1 : i - 1)] -= i % 2 ? cross : -cross;
    }
    to += size;
  }
  if (layout_.size == 1) return;
  delta_.resize(size * blocks_.size());
  MPI_Allgatherv(own.data(), counts[layout_.rank], MPI_DOUBLE, delta_.data(), counts.data(), starts.data(), MPI_DOUBLE,
                 layout_.comm);
}

// matrix_ = I + F Delta, harmonic by harmonic of its rows.
void ContactFactors::fill() {
  const int w = layout_.width;
  const std::size_t rows = factored_.size(), size = rows * w;
  matrix_.assign(size * size, 0);
  in_phase_.resize(rows * rows), out_of_phase_.resize(rows * rows);
  for (int k = 0; k <= w / 2; ++k) {
    flexibility(k, in_phase_.data(), out_of_phase_.data());
    for (std::size_t i = 0; i < rows; ++i) {
      const double *part = delta_.data();
      for (const Block &block : blocks_) {
        if (block.acts) {
          const double a = in_phase_[i * rows + block.row], b = k > 0 ? out_of_phase_[i * rows + block.row] : 0;
          double *c = &matrix_[(i * w + (k > 0 ? cosine(k) : 0)) * size + block.column * w], *s = c + size;
          const double *pc = part + (k > 0 ? cosine(k) : 0) * w, *ps = pc + w;
          if (k == 0)
            for (int j = 0; j < w; ++j) c[j] += a * pc[j];
          else
            for (int j = 0; j < w; ++j) c[j] += a * pc[j] - b * ps[j], s[j] += b * pc[j] + a * ps[j];
        }
        part += static_cast<std::size_t>(w) * w;
      }
    }
  }
  for (std::size_t i = 0; i < size; ++i) matrix_[i * size + i] += 1;
}

int ContactFactors::decompose(const JacobianParts &parts, bool precisely) {
  constexpr PetscInt small = 300;
  list_blocks();
  gather_deltas(parts);
  const double *part = delta_.data();
  for (Block &block : blocks_) {
    const double *end = part + static_cast<std::size_t>(layout_.width) * layout_.width;
    block.acts = std::any_of(std::exchange(part, end), end, [](double value) { return value != 0; });
  }
  fill();
  pivots_.clear(), rough_ = {};
  if (static_cast<PetscInt>(factored_.size()) * layout_.width > small && !precisely) {
    rough_.factor({matrix_.begin(), matrix_.end()});
    return rough_.sign();
  }
  return factor_in_place(matrix_, pivots_);
}

void ContactFactors::react() {
  const PetscBLASInt width = layout_.width, one = 1;
  const double plus = 1, minus = -1;
  if (rough_.size() == 0) {
    solve_in_place(matrix_, pivots_, motion_.data());
  } else {
    rough_motion_.assign(motion_.begin(), motion_.end());
    rough_.solve(rough_motion_.data(), true);
    std::copy(rough_motion_.begin(), rough_motion_.end(), motion_.begin());
  }
  for (std::size_t b = 0; b < blocks_.size(); ++b)
    if (blocks_[b].acts)
      BLASgemv_("T", &width, &width, &minus, &delta_[b * width * width], &width, &motion_[blocks_[b].column * width],
                &one, &plus, &force_[blocks_[b].row * width], &one);
}

} // namespace dovetail
