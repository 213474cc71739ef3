#include "modal/window_factors.hpp"

#include <algorithm>
#include <cmath>

namespace dovetail {
namespace {

constexpr double most_closed = 0.7; // of the period; beyond, all waves are taken
constexpr double beyond = 5;        // waves that each span of a window takes more than it is long, about

double closed_part(const ContactForces &contact, int p) { // of the period
  return contact.springs_only(p) ? 1 : contact.derivative(p).closed.cosine[0];
}

int first_direction(const ContactForces &contact, int p) { return has_friction(contact.points()[p].law) ? 0 : 2; }

// Operations, as ContactFactors::work, of W^T F W and of LAPACK.
double products_of(double width, double size) { return 3.5 * (2 * width + 0.7 * size) * size * size; }

} // namespace

// Without looking at any window.
bool WindowFactors::plausible(const ContactForces &contact, double worth) const {
  double least[] = {0, 0}; // waves; laws that have no windows
  for (int p = 0; p < contact.size(); ++p) {
    const Linearisation &derivative = contact.derivative(p);
    const double closed = closed_part(contact, p),
                 waves = std::min<double>(layout_.width, closed * layout_.width + beyond * derivative.spans);
    if (closed > 0) least[0] += (3 - first_direction(contact, p)) * waves;
    least[1] += !derivative.dense.empty();
  }
  MPI_Allreduce(MPI_IN_PLACE, least, 2, MPI_DOUBLE, MPI_SUM, layout_.comm);
  return least[1] == 0 && products_of(layout_.width, least[0]) < worth;
}

bool WindowFactors::look_at(const ContactForces &contact, double worth) {
  const std::size_t w = layout_.width;
  forget();
  if (!plausible(contact, worth)) return false;
  moving_.clear(), own_.clear();
  std::size_t left = 0; // of the waves that are worth it
  while (products_of(w, left) < worth) ++left;
  int fits = true;
  for (int p = 0; p < contact.size() && fits; ++p) {
    const double closed = closed_part(contact, p);
    if (closed == 0) continue;
    const std::size_t first = first_direction(contact, p), directions = 3 - first, most = left / directions;
    own_.push_back(closed < most_closed ? window_of(contact.derivative(p).closed, std::min(most, w))
                                        : whole_window(layout_.width / 2));
    const std::size_t waves = own_.back().waves.size();
    fits = waves > 0 && waves <= most;
    left -= fits ? directions * waves : 0;
    for (int d = static_cast<int>(first); d < 3; ++d) moving_.push_back(3 * p + d);
  }
  MPI_Allreduce(MPI_IN_PLACE, &fits, 1, MPI_INT, MPI_LAND, layout_.comm);
  if (!fits) return false;
  list_windows();
  return work() < worth;
}

// windows_ of all ranks, from own_ and moving_.
void WindowFactors::list_windows() {
  share_moving();
  std::vector<int> own, ranks;
  for (const Window &window : own_) own.push_back(static_cast<int>(window.waves.size()));
  gather(layout_, std::move(own), ranks, MPI_INT);
  windows_.clear(), size_ = 0;
  std::size_t weights = 0, delta = 0, row = 0;
  for (const int rank : ranks) {
    Place window{row, 0, static_cast<std::size_t>(rank), size_, weights, delta};
    while (row < all_moving_.size() && all_moving_[row] / 3 == all_moving_[window.row] / 3) ++row;
    window.directions = row - window.row;
    size_ += window.combinations(), weights += static_cast<std::size_t>(layout_.width) * rank;
    delta += window.combinations() * window.combinations();
    windows_.push_back(window);
  }
}

double WindowFactors::work() const {
  const double w = layout_.width, rows = static_cast<double>(all_moving_.size()), size = static_cast<double>(size_),
               n = static_cast<double>(n_);
  double products = 0;
  for (const Place &window : windows_) {
    const double rank = static_cast<double>(window.rank), all = static_cast<double>(window.combinations());
    products += 4 * w * rank * rank + 100 * rank * rank + 2 * size * size * all;
  }
  return products_of(w, size) + 3.5 * products + 6 * w * rows * rows * n + 2e5;
}

double WindowFactors::work_to_solve() const {
  const double rows = static_cast<double>(all_moving_.size()), size = static_cast<double>(size_),
               n = static_cast<double>(n_);
  return 25 * size * size + 8 * layout_.width * (n * (rows + n) + size) + 1e5;
}

// The mean of a motion is a_0 / sqrt 2 here.
void WindowFactors::gather_deltas(const ContactForces &contact) {
  std::vector<double> own;
  std::size_t dof = 0;
  for (const Window &window : own_) {
    const int p = moving_[dof] / 3, first = moving_[dof] % 3, rank = static_cast<int>(window.waves.size());
    const std::size_t directions = 3 - first, all = directions * rank, begin = own.size();
    own.resize(begin + all * all);
    written_.resize(9 * static_cast<std::size_t>(rank) * rank);
    if (rank == layout_.width)
      contact.write(p, written_.data());
    else
      contact.write(p, window.waves.data(), rank, written_.data());
    const double *from = written_.data();
    for (const BlockPlace &place : block_places(contact.points()[p].law)) {
      double *to = &own[begin + (place.row - first) * rank * all + (place.column - first) * rank];
      for (int i = 0; i < rank; ++i)
        for (int j = 0; j < rank; ++j, ++from) {
          const int row = window.waves[i], column = window.waves[j];
          to[i * all + j] = *from * ((row == 0) == (column == 0) ? 1 : row == 0 ? M_SQRT1_2 : M_SQRT2);
        }
    }
    dof += directions;
  }
  gather(layout_, std::move(own), deltas_, MPI_DOUBLE);
}

// seen_ = W^T F W and matrix_ = I + W^T F W C, by rows.
void WindowFactors::fill() {
  const std::size_t w = layout_.width, rows = factored_.size(), each = rows * rows, harmonics = w / 2;
  in_phase_.resize((harmonics + 1) * each), out_of_phase_.resize(in_phase_.size());
  for (std::size_t k = 0; k <= harmonics; ++k)
    flexibility(static_cast<int>(k), in_phase_.data() + k * each, out_of_phase_.data() + k * each);
  seen_.resize(size_ * size_), matrix_.resize(size_ * size_);
  for (const Place &from : windows_)
    for (std::size_t j = 0; j < from.directions; ++j)
      for (const Place &to : windows_)
        for (std::size_t i = 0; i < to.directions; ++i) {
          const double *a = &in_phase_[(to.row + i) * rows + from.row + j],
                       *b = &out_of_phase_[(to.row + i) * rows + from.row + j];
          half_.resize(w * from.rank);
          for (std::size_t r = 0; r < from.rank; ++r) {
            const double *v = &weights_[from.weights + r * w];
            double *out = &half_[r * w];
            out[0] = a[0] * v[0];
            for (std::size_t k = 1; k <= harmonics; ++k) {
              const std::size_t c = 2 * k - 1, s = 2 * k;
              out[c] = a[k * each] * v[c] - b[k * each] * v[s], out[s] = b[k * each] * v[c] + a[k * each] * v[s];
            }
          }
          gemm("T", "N", from.rank, to.rank, w, half_.data(), w, &weights_[to.weights], w, 0,
               &seen_[(to.at + i * to.rank) * size_ + from.at + j * from.rank], size_);
        }
  for (const Place &window : windows_) {
    const std::size_t all = window.combinations();
    gemm("N", "N", all, size_, all, &deltas_[window.delta], all, &seen_[window.at], size_, 0, &matrix_[window.at],
         size_);
  }
  for (std::size_t i = 0; i < size_; ++i) matrix_[i * size_ + i] += 1;
}

int WindowFactors::decompose(const JacobianParts &parts, bool) {
  std::vector<double> own;
  for (const Window &window : own_) own.insert(own.end(), window.weights.begin(), window.weights.end());
  gather(layout_, std::move(own), weights_, MPI_DOUBLE);
  gather_deltas(parts.contact.forces());
  fill();
  return factor_in_place(matrix_, pivots_);
}

void WindowFactors::react() {
  const std::size_t w = layout_.width;
  combined_.resize(size_), force_of_.resize(size_);
  for (std::size_t i = 0; i < factored_.size(); ++i) motion_[i * w] /= M_SQRT2;
  for (const Place &window : windows_)
    gemm("T", "N", window.rank, window.directions, w, &weights_[window.weights], w, &motion_[window.row * w], w, 0,
         &combined_[window.at], window.rank);
  solve_in_place(matrix_, pivots_, combined_.data());
  for (const Place &window : windows_) {
    const std::size_t all = window.combinations();
    gemm("T", "N", all, 1, all, &deltas_[window.delta], all, &combined_[window.at], all, 0, &force_of_[window.at], all);
    gemm("N", "N", w, window.directions, window.rank, &weights_[window.weights], w, &force_of_[window.at], window.rank,
         0, &force_[window.row * w], w);
  }
  for (double &f : force_) f = -f;
  for (std::size_t i = 0; i < factored_.size(); ++i) force_[i * w] *= M_SQRT2;
}

} // namespace dovetail
