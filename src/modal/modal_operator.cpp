#include "modal/modal_operator.hpp"

#include <algorithm>

#include "contact/wide.hpp"
#include "support/event.hpp"

extern "C" void sgemm_(const char *, const char *, const int *, const int *, const int *, const float *, const float *,
                       const int *, const float *, const int *, const float *, float *, const int *);

namespace dovetail {
namespace {

constexpr PetscInt points_at_once = 8; // 24 rows of Phi: they stay in the cache between the two products

// force += block times motion, block (width columns of `padded`).
DOVETAIL_WIDE void add_to(const float *__restrict block, int width, int padded, const float *__restrict motion,
                          float *__restrict force) {
  for (int j = 0; j < width; ++j) {
    const float factor = motion[j];
    for (int i = 0; i < padded; ++i) force[i] += block[j * padded + i] * factor;
  }
}

// Rows of `to`, `stride` apart, += scale factors shape^T.
DOVETAIL_WIDE void add_outer(float scale, const float *__restrict factors, int rows, const float *__restrict shape,
                             int count, float *__restrict to, std::size_t stride) {
  for (int i = 0; i < rows; ++i) {
    const float factor = scale * factors[i];
    for (int m = 0; m < count; ++m) to[i * stride + m] += factor * shape[m];
  }
}

} // namespace

ModalOperator::ModalOperator(const StuckBases &bases, const Layout &layout, const ModalShare &held)
    : basis_(bases.mean()), layout_(layout), everywhere_(held.everywhere), own_(held.own),
      padded_(padded<Real>(layout.width)), counts_(layout.size), starts_(layout.size),
      points_(layout.own_points.size()), cross_(padded_),
      written_(9 * static_cast<std::size_t>(layout.width) * layout.width) {
  for (int r = 0; r < layout.size; ++r) {
    const Range share = share_of(layout.dofs(), r, layout.size);
    counts_[r] = share.size() * padded_ + (r == layout.size - 1), starts_[r] = share.begin * padded_;
  }
  const std::size_t all = static_cast<std::size_t>(layout.dofs()) * padded_ + 1;
  all_ = Aligned<Real>(all), sum_ = Aligned<Real>(all), share_ = Aligned<Real>(counts_[layout.rank]);
  for (const IndexGroup &group : groups_of(bases.wave, layout.width)) {
    const StuckBasis &basis = *bases.of_index[group.index];
    Bundle<Real> given(basis.phi, group.columns()), summed(basis.phi, group.columns());
    const std::size_t few = 3 * points_at_once * group.columns();
    sheaves_.push_back({group, basis, std::move(given), std::move(summed), Aligned<Real>(few)});
  }
  const std::size_t rows = std::max<std::size_t>(layout.own_dofs(), 3 * points_at_once);
  motion_ = Aligned<Real>(rows * padded_), force_ = Aligned<Real>(rows * padded_);
}

void ModalOperator::take(const ContactDerivative &contact, const double *held, const DynamicStiffness &structure) {
  const Timed timed(Work::contact);
  const int n = layout_.width;
  const std::size_t size = static_cast<std::size_t>(n) * padded_;
  structure_ = structure;
  for (int i = 1; i < n; ++i) cross_[i] = static_cast<Real>((i % 2 ? 1 : -1) * structure.loss((i + 1) / 2));
  std::size_t count = 0;
  for (int p = 0; p < contact.size(); ++p) {
    Point &point = points_[p];
    point.blocks.clear();
    const double *springs = &basis_.springs[3 * p];
    const auto own = stuck_springs(contact.points()[p]);
    point.stuck = contact.springs_only(p) && std::equal(own.begin(), own.end(), springs);
    if (point.stuck) continue;
    const auto &places = contact.places(p);
    contact.write(p, written_.data());
    if (blocks_.size() < (count + places.size()) * size) { // room for all points at once
      Aligned<Real> larger(static_cast<std::size_t>(contact.size()) * 7 * size);
      std::copy_n(blocks_.data(), count * size, larger.data());
      blocks_ = std::move(larger);
    }
    for (std::size_t b = 0; b < places.size(); ++b, ++count) {
      Real *block = &blocks_[count * size];
      const double *written = &written_[b * n * n];
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) block[j * padded_ + i] = static_cast<Real>(written[i * n + j]);
      point.blocks.push_back({places[b].row, places[b].column, count * size});
      if (places[b].row != places[b].column) continue;
      const double spring = springs[places[b].row];
      for (int i = 0; i < n; ++i) {
        block[i * padded_ + i] = static_cast<Real>(written[i * n + i] - spring);
        const int pair = i == 0 ? 0 : i % 2 ? i + 1 : i - 1;
        if (pair > 0) block[pair * padded_ + i] = static_cast<Real>(written[i * n + pair] - spring * cross_[i]);
      }
      if (held) block[0] += static_cast<Real>(held[3 * p + places[b].row]);
    }
  }
}

// all_ = the modal unknowns of all ranks, and of each basis those of its harmonics.
void ModalOperator::spread(const double *y, double last) {
  Real *own = &all_[own_.begin * padded_];
  const PetscInt rows = own_.size();
  for (PetscInt i = 0; i < rows; ++i)
    for (int j = 0; j < layout_.width; ++j) own[i * padded_ + j] = static_cast<Real>(y[i * layout_.width + j]);
  if (everywhere_ || layout_.owns_omega()) own[rows * padded_] = static_cast<Real>(last);
  const Timed timed(Work::exchange);
  if (!everywhere_)
    MPI_Allgatherv(MPI_IN_PLACE, 0, MPI_DATATYPE_NULL, all_.data(), counts_.data(), starts_.data(), MPI_FLOAT,
                   layout_.comm);
  const std::size_t n = layout_.dofs();
  for (Sheaf &sheaf : sheaves_)
    for (std::size_t j = 0; j < n; ++j)
      for (int c = 0; c < sheaf.of.columns(); ++c) {
        sheaf.all.at(j, c) = sheaf.of.real(c, &all_[j * padded_]);
        if (sheaf.of.complex) sheaf.all.at(n + j, c) = sheaf.of.imaginary(c, &all_[j * padded_]);
      }
}

// motion (count, padded) = rows of Phi times what was spread, from `row` on, few at a time.
void ModalOperator::move(PetscInt row, PetscInt count, Real *motion) {
  for (Sheaf &sheaf : sheaves_) {
    const int strands = sheaf.all.strands();
    sheaf.all.multiplied(sheaf.basis.phi, row, count, sheaf.few.data());
    for (PetscInt i = 0; i < count; ++i)
      for (int c = 0; c < sheaf.of.columns(); ++c)
        motion[i * padded_ + sheaf.of.coefficients[c]] = sheaf.few[i * strands + c];
  }
}

// Adds those rows' transpose, times the force, to the sums.
void ModalOperator::press(PetscInt row, PetscInt count, const Real *force) {
  for (Sheaf &sheaf : sheaves_) {
    const int strands = sheaf.sum.strands();
    for (PetscInt i = 0; i < count; ++i)
      for (int c = 0; c < sheaf.of.columns(); ++c)
        sheaf.few[i * strands + c] = force[i * padded_ + sheaf.of.coefficients[c]];
    sheaf.sum.add_transposed_of(sheaf.basis.phi, row, count, sheaf.few.data());
  }
}

void ModalOperator::clear_sum() {
  for (Sheaf &sheaf : sheaves_) sheaf.sum.clear();
}

// to (n, padded) = the sums of this rank.
void ModalOperator::list_sum(Real *to) const {
  const std::size_t n = layout_.dofs();
  for (const Sheaf &sheaf : sheaves_)
    for (std::size_t j = 0; j < n; ++j)
      for (int c = 0; c < sheaf.of.columns(); ++c)
        to[j * padded_ + sheaf.of.coefficients[c]] = sheaf.of.joined(
            c, sheaf.sum.at(j, c), sheaf.of.complex ? sheaf.sum.at(n + j, sheaf.of.partners[c]) : Real{});
}

void ModalOperator::take_own(const Real *share, double *out) const {
  for (PetscInt i = 0; i < own_.size(); ++i)
    for (int j = 0; j < layout_.width; ++j) out[i * layout_.width + j] = share[i * padded_ + j];
}

// out = own part of the sums over all ranks.
void ModalOperator::collect(double *out, double *sum) {
  list_sum(sum_.data());
  const Timed timed(Work::exchange);
  const Real *share = sum_.data();
  if (everywhere_) {
    MPI_Allreduce(MPI_IN_PLACE, sum_.data(), static_cast<int>(layout_.dofs()) * padded_, MPI_FLOAT, MPI_SUM,
                  layout_.comm);
  } else if (layout_.size > 1) {
    MPI_Reduce_scatter(sum_.data(), share_.data(), counts_.data(), MPI_FLOAT, MPI_SUM, layout_.comm);
    share = share_.data();
  }
  take_own(share, out);
  if (!everywhere_ && layout_.owns_omega() && sum) *sum = share[own_.size() * padded_];
}

// The sums of Phi^H r of this rank.
void ModalOperator::press_all(const double *r) {
  clear_sum();
  const double *const end = r + layout_.own_coefficients();
  if (std::all_of(r, end, [](double value) { return value == 0; })) return; // a tangent's right-hand side
  for (PetscInt d = 0; d < layout_.own_dofs(); ++d)
    for (int j = 0; j < layout_.width; ++j) motion_[d * padded_ + j] = static_cast<Real>(r[d * layout_.width + j]);
  const Timed timed(Work::modes);
  for (PetscInt d = 0; d < layout_.own_dofs(); d += 3 * points_at_once)
    press(d, std::min(3 * points_at_once, layout_.own_dofs() - d), &motion_[d * padded_]);
}

// Sums travel in two parts, so that no digit is lost.
void ModalOperator::to_modes(const std::vector<Forces> &forces, std::vector<double> &sums, std::vector<Real> &rough) {
  if (!everywhere_) {
    for (const Forces &of : forces) press_all(of.given), collect(of.modal, nullptr);
    MPI_Allreduce(MPI_IN_PLACE, sums.data(), static_cast<int>(sums.size()), MPI_DOUBLE, MPI_SUM, layout_.comm);
    MPI_Allreduce(MPI_IN_PLACE, rough.data(), static_cast<int>(rough.size()), MPI_FLOAT, MPI_SUM, layout_.comm);
    return;
  }
  const std::size_t each = static_cast<std::size_t>(layout_.dofs()) * padded_;
  message_.assign(forces.size() * each + 2 * sums.size(), 0);
  Real *const behind = &message_[forces.size() * each];
  for (std::size_t i = 0; i < forces.size(); ++i) press_all(forces[i].given), list_sum(&message_[i * each]);
  for (std::size_t i = 0; i < sums.size(); ++i) {
    behind[2 * i] = static_cast<Real>(sums[i]);
    behind[2 * i + 1] = static_cast<Real>(sums[i] - behind[2 * i]);
  }
  const std::size_t before_rough = message_.size();
  message_.insert(message_.end(), rough.begin(), rough.end());
  {
    const Timed timed(Work::exchange);
    MPI_Allreduce(MPI_IN_PLACE, message_.data(), static_cast<int>(message_.size()), MPI_FLOAT, MPI_SUM, layout_.comm);
  }
  for (std::size_t i = 0; i < forces.size(); ++i) take_own(&message_[i * each], forces[i].modal);
  const Real *const summed = &message_[forces.size() * each];
  for (std::size_t i = 0; i < sums.size(); ++i) sums[i] = static_cast<double>(summed[2 * i]) + summed[2 * i + 1];
  rough.assign(message_.begin() + before_rough, message_.end());
}

void ModalOperator::from_modes(const double *y, double *q) {
  spread(y, 0);
  const Timed timed(Work::modes);
  for (PetscInt d = 0; d < layout_.own_dofs(); d += 3 * points_at_once)
    move(d, std::min(3 * points_at_once, layout_.own_dofs() - d), &motion_[d * padded_]);
  for (PetscInt d = 0; d < layout_.own_dofs(); ++d)
    for (int j = 0; j < layout_.width; ++j) q[d * layout_.width + j] = motion_[d * padded_ + j];
}

// force_ = { dG - kappa_k K_t } motion_ of a few points.
void ModalOperator::contact_forces(PetscInt first, PetscInt count) {
  std::fill_n(force_.data(), 3 * count * padded_, Real{});
  for (PetscInt p = 0; p < count; ++p) {
    const Point &point = points_[first + p];
    const Real *motion = &motion_[3 * p * padded_];
    Real *force = &force_[3 * p * padded_];
    for (const Block &block : point.blocks)
      add_to(&blocks_[block.at], layout_.width, padded_, motion + block.column * padded_, force + block.row * padded_);
    for (int d = 0; d < 3 && point.stuck; ++d) {
      const Real spring = static_cast<Real>(basis_.springs[3 * (first + p) + d]);
      for (int i = 1; i < layout_.width; ++i)
        force[d * padded_ + i] = -spring * cross_[i] * motion[d * padded_ + (i % 2 ? i + 1 : i - 1)];
    }
  }
}

// First what the points answer to each motion, (3 points, 2H+1, unknowns), then its sum over them.
std::vector<float> ModalOperator::among(const std::vector<Motions> &motions) const {
  constexpr PetscInt at_once = 32;
  const int w = layout_.width;
  struct Place { // of a coefficient
    const Motions *motions;
    int column;
    std::size_t first; // unknown
  };
  std::vector<Place> places(w);
  std::size_t size = 0;
  for (const Motions &group : motions)
    for (int c = 0; c < group.of.columns(); ++c, size += group.count)
      places[group.of.coefficients[c]] = {&group, c, size};
  const std::size_t row = w * size;
  std::vector<Real> sum(size * size), answers(3 * at_once * row);
  std::vector<std::vector<Real>> of_real(w), of_imaginary(w); // (size, count) by coefficient of the force
  for (int i = 0; i < w; ++i) {
    of_real[i].resize(size * places[i].motions->count);
    of_imaginary[i].resize(places[i].motions->of.complex ? of_real[i].size() : 0);
  }
  for (PetscInt first = 0; first < layout_.own_points.size(); first += at_once) {
    const PetscInt count = std::min(at_once, layout_.own_points.size() - first);
    std::fill_n(answers.begin(), 3 * count * row, Real{});
    for (PetscInt p = 0; p < count; ++p) {
      const Point &point = points_[first + p];
      // coefficients of the force in direction `to` from the i-th on, by the j-th of the motion in direction `from`
      const auto add = [&](int to, int i, int from, int j, const Real *factors, int rows) {
        Real *const answer = &answers[(3 * p + to) * row + i * size];
        const auto &[group, column, unknown] = places[j];
        const std::size_t shape = (3 * (first + p) + from) * group->count;
        const int shapes = static_cast<int>(group->count);
        add_outer(1, factors, rows, &group->real[shape], shapes, answer + unknown, size);
        if (!group->of.complex) return;
        const std::size_t other = places[group->of.coefficients[group->of.partners[column]]].first;
        add_outer(static_cast<Real>(group->of.turns[column]), factors, rows, &group->imaginary[shape], shapes,
                  answer + other, size);
      };
      for (const Block &block : point.blocks)
        for (int j = 0; j < w; ++j) add(block.row, 0, block.column, j, &blocks_[block.at + j * padded_], w);
      for (int d = 0; d < 3 && point.stuck; ++d)
        for (int i = 1; i < w; ++i) {
          const Real damped = -static_cast<Real>(basis_.springs[3 * (first + p) + d]) * cross_[i];
          add(d, i, d, i % 2 ? i + 1 : i - 1, &damped, 1);
        }
    }
    const int rows = static_cast<int>(size), stride = static_cast<int>(row), inner = static_cast<int>(3 * count);
    const Real one = 1;
    for (int i = 0; i < w; ++i) {
      const Motions &group = *places[i].motions;
      const int columns = static_cast<int>(group.count);
      const auto sum_up = [&](const std::vector<Real> &shapes, std::vector<Real> &to) {
        sgemm_("N", "T", &rows, &columns, &inner, &one, &answers[i * size], &stride, &shapes[3 * first * group.count],
               &columns, &one, to.data(), &rows);
      };
      sum_up(group.real, of_real[i]);
      if (group.of.complex) sum_up(group.imaginary, of_imaginary[i]);
    }
  }
  for (int i = 0; i < w; ++i) {
    const auto &[group, column, unknown] = places[i];
    const int other = group->of.coefficients[group->of.partners[column]];
    for (PetscInt m = 0; m < group->count; ++m)
      for (std::size_t u = 0; u < size; ++u)
        sum[u * size + unknown + m] = group->of.joined(column, of_real[i][m * size + u],
                                                       group->of.complex ? of_imaginary[other][m * size + u] : Real{});
  }
  return sum;
}

// With two strands every number of a slab comes from memory: as long as 8 to 15 operations, for 300 to 1800 rows,
// measured.
double ModalOperator::work() const {
  constexpr double from_memory = 12;
  double sum = 0;
  for (const Sheaf &sheaf : sheaves_) {
    const double entries = 3.0 * layout_.points * static_cast<double>(sheaf.basis.phi.columns());
    sum += entries * (4 * sheaf.all.strands() + (sheaf.of.whole ? 0 : from_memory));
  }
  return sum;
}

void ModalOperator::apply(const double *y, double *out, double &last, double &sum) {
  spread(y, last);
  if (!everywhere_) last = all_[static_cast<std::size_t>(layout_.dofs()) * padded_];
  clear_sum();
  {
    const Timed timed(Work::modes);
    const PetscInt points = layout_.own_points.size();
    for (PetscInt p = 0; p < points; p += points_at_once) {
      const PetscInt count = std::min(points_at_once, points - p), row = layout_.own_modes.size() + 3 * p;
      move(row, 3 * count, motion_.data());
      contact_forces(p, count);
      press(row, 3 * count, force_.data());
    }
  }
  sum_[static_cast<std::size_t>(layout_.dofs()) * padded_] = static_cast<Real>(sum);
  collect(out, everywhere_ ? nullptr : &sum);
  if (basis_.dampers_are_diagonal()) return;
  add_dampers(basis_.viscous, &DynamicStiffness::turn, out);
  add_dampers(basis_.hysteretic, &DynamicStiffness::hysteresis, out);
}

void ModalOperator::add_dampers(const Slab<float> &rows, double (DynamicStiffness::*factor)(int) const, double *out) {
  if (rows.columns() == 0) return;
  const std::size_t own = own_.size(), w = layout_.width;
  if (damped_.size() < own * w) damped_ = Aligned<Real>(own * w);
  sheaves_.front().all.multiplied(rows, 0, own, damped_.data()); // there are no sectors: it has all coefficients
  for (std::size_t i = 0; i < own; ++i)
    for (int k = 1; k <= layout_.width / 2; ++k) {
      const double times = (structure_.*factor)(k);
      out[i * layout_.width + cosine(k)] += times * damped_[i * w + sine(k)];
      out[i * layout_.width + sine(k)] -= times * damped_[i * w + cosine(k)];
    }
}

} // namespace dovetail
