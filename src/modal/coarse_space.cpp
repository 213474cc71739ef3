#include "modal/coarse_space.hpp"

#include <algorithm>
#include <cmath>

#include "modal/modal_factors.hpp"
#include "support/event.hpp"

namespace dovetail {
namespace {

constexpr double near_by = 1.5; // times the highest harmonic's frequency are the highest modes it comes near to

} // namespace

CoarseSpace::CoarseSpace(const StuckBases &bases, const Layout &layout, const ModalShare &share)
    : layout_(layout), own_(share.own), most_(share.few) {
  PetscBool given;
  check(PetscOptionsGetInt(nullptr, "hb_modal_", "-lowest", &most_, &given), "reading options");
  given_ = given;
  if (!used()) return;
  for (IndexGroup &group : groups_of(bases.wave, layout.width)) {
    parts_.push_back({*bases.of_index[group.index], -1, 0, {}, {}, {}, {}, {}, {}, {}});
    at_contacts_.push_back({std::move(group), 0, {}, {}});
  }
}

// Motions for this frequency.
void CoarseSpace::choose(double omega) {
  const PetscInt n = layout_.dofs();
  const double reach = near_by * (layout_.width / 2) * omega;
  size_ = 0;
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    Part &part = parts_[p];
    const std::vector<double> &lambda = part.basis.lambda;
    const bool complex = at_contacts_[p].of.complex;
    const PetscInt known = static_cast<PetscInt>(part.basis.shapes.size()) / (complex ? 2 * n : n),
                   near = static_cast<PetscInt>(std::lower_bound(lambda.begin(), lambda.end(), reach * reach) -
                                                lambda.begin()),
                   shapes = given_ ? known : std::min(known, most_ / 2),
                   lowest = given_ ? std::min(most_, n) : std::clamp<PetscInt>(near, 1, most_ - shapes);
    if (lowest != part.lowest) choose(lowest, std::min(shapes, n - lowest), p);
    part.first = size_;
    size_ += at_contacts_[p].count * at_contacts_[p].of.columns();
  }
}

void CoarseSpace::choose(PetscInt lowest, PetscInt shapes, std::size_t number) {
  Part &part = parts_[number];
  ModalOperator::Motions &at_contacts = at_contacts_[number];
  const StuckBasis &basis = part.basis;
  const std::size_t n = layout_.dofs(), c = lowest + shapes, rows = 3 * layout_.own_points.size(),
                    own_modes = layout_.own_modes.size();
  const bool complex = at_contacts.of.complex;
  part.lowest = lowest, at_contacts.count = static_cast<PetscInt>(c);
  part.motions.assign(n * c, 0), part.imaginary.assign(complex ? n * c : 0, 0);
  for (PetscInt k = 0; k < lowest; ++k) part.motions[k * n + k] = 1;
  for (std::size_t k = lowest; k < c; ++k) {
    const double *shape = &basis.shapes[(k - lowest) * (complex ? 2 * n : n)];
    std::copy(shape + lowest, shape + n, &part.motions[k * n] + lowest);
    if (complex) std::copy(shape + n + lowest, shape + 2 * n, &part.imaginary[k * n] + lowest);
  }
  std::vector<double> moved(rows * c);
  const auto move = [&](double sign, const std::vector<double> &motions, std::size_t offset, double beta) {
    std::vector<double> signed_motions(motions);
    for (double &value : signed_motions) value *= sign;
    basis.each_part(own_modes, [&](const double *of, std::size_t stride, std::size_t first, std::size_t many) {
      gemm("T", "N", c, many, n, signed_motions.data(), n, of + offset, stride, beta, &moved[first * c], c);
    });
  };
  move(1, part.motions, 0, 0);
  if (complex) move(-1, part.imaginary, n, 1);
  at_contacts.real.assign(moved.begin(), moved.end());
  if (complex) {
    move(1, part.imaginary, 0, 0), move(1, part.motions, n, 1);
    at_contacts.imaginary.assign(moved.begin(), moved.end());
  }
  const auto products = [&](const std::vector<double> *diagonal, Products &of) {
    of.real.assign(c * c, 0), of.imaginary.assign(complex ? c * c : 0, 0);
    for (std::size_t i = 0; i < c; ++i)
      for (std::size_t k = 0; k < c; ++k)
        for (std::size_t j = 0; j < n; ++j) {
          const double factor = diagonal ? (*diagonal)[j] : 1, a = part.motions[i * n + j], b = part.motions[k * n + j];
          of.real[i * c + k] += factor * (a * b);
          if (!complex) continue;
          const double a_i = part.imaginary[i * n + j], b_i = part.imaginary[k * n + j];
          of.real[i * c + k] += factor * (a_i * b_i), of.imaginary[i * c + k] += factor * (a * b_i - a_i * b);
        }
  };
  products(&basis.lambda, part.stiff), products(nullptr, part.heavy), products(&basis.damped, part.damped);
  products(&basis.rates, part.rates), products(&basis.losses, part.losses);
}

// As SectorAssembled, of an entry of the motions' matrices.
CoarseSpace::Blocks CoarseSpace::blocks(const DynamicStiffness &structure, const Part &of, const Products &damped,
                                        int k, double sign, std::size_t at) const {
  const double damper = structure.turn(k) * of.rates.real[at] + structure.hysteresis(k) * of.losses.real[at];
  Blocks made{structure.in_phase(k, of.stiff.real[at], of.heavy.real[at]),
              structure.quadrature(k, damped.real[at], of.heavy.real[at]) + damper};
  if (of.stiff.imaginary.empty()) return made;
  made.A -= sign * structure.quadrature(k, damped.imaginary[at], of.heavy.imaginary[at]);
  made.B += sign * structure.in_phase(k, of.stiff.imaginary[at], of.heavy.imaginary[at]);
  return made;
}

template <class Work> void CoarseSpace::each_harmonic(Work &&work) const {
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    const ModalOperator::Motions &of = at_contacts_[p];
    for (int c = 0; c < of.of.columns(); c += of.of.coefficients[c] == 0 ? 1 : 2)
      work(p, (of.of.coefficients[c] + 1) / 2, of.of.turns[c],
           parts_[p].first + static_cast<std::size_t>(c) * of.count);
  }
}

std::vector<float> CoarseSpace::part(const ModalOperator &contacts, const DynamicStiffness &structure) {
  const Timed timed(Work::factors);
  choose(structure.omega());
  return contacts.among(at_contacts_);
}

void CoarseSpace::factor(std::vector<float> matrix, const DynamicStiffness &structure) {
  const Timed timed(Work::factors);
  const std::size_t size = size_;
  each_harmonic([&](std::size_t p, int k, double sign, std::size_t first) {
    const std::size_t c = at_contacts_[p].count;
    for (std::size_t i = 0; i < c; ++i)
      for (std::size_t j = 0; j < c; ++j) {
        const auto [A, B] = blocks(structure, parts_[p], parts_[p].stiff, k, sign, i * c + j);
        float *const at = &matrix[(first + j) * size + first + i], *const sine = at + c * size;
        at[0] += static_cast<float>(A);
        if (k == 0) continue;
        sine[c] += static_cast<float>(A), sine[0] += static_cast<float>(B), at[c] -= static_cast<float>(B);
      }
  });
  jacobian_.factor(std::move(matrix));
  factor_diagonal(structure);
}

// Its determinant is not negative: that of the mean is of a stiffness, those of harmonics are of complex matrices.
void CoarseSpace::factor_diagonal(const DynamicStiffness &structure) {
  diagonal_.resize(layout_.width / 2 + 1);
  bool regular = true;
  each_harmonic([&](std::size_t p, int k, double sign, std::size_t) {
    const std::size_t c = at_contacts_[p].count, size = k == 0 ? c : 2 * c;
    std::vector<float> matrix(size * size);
    for (std::size_t i = 0; i < c; ++i)
      for (std::size_t j = 0; j < c; ++j) {
        const auto [A, B] = blocks(structure, parts_[p], parts_[p].damped, k, sign, i * c + j);
        matrix[j * size + i] = static_cast<float>(A);
        if (k == 0) continue;
        matrix[(c + j) * size + c + i] = static_cast<float>(A), matrix[(c + j) * size + i] = static_cast<float>(B);
        matrix[j * size + c + i] = -static_cast<float>(B);
      }
    regular = diagonal_[k].factor(std::move(matrix)) && regular;
  });
  sign_ = regular ? jacobian_.sign() : 0;
}

void CoarseSpace::to_motions(const double *v, double *g) const {
  const std::size_t w = layout_.width, n = layout_.dofs(), own = own_.size();
  if (size() == 0) return;
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    const IndexGroup &of = at_contacts_[p].of;
    const std::size_t columns = of.columns(), c = at_contacts_[p].count;
    std::vector<double> parted(own * columns), product(c * columns);
    for (std::size_t j = 0; j < own; ++j)
      for (std::size_t q = 0; q < columns; ++q) parted[j * columns + q] = v[j * w + of.coefficients[q]];
    const auto times = [&](const std::vector<double> &motions, double *to) {
      gemm("T", "T", c, columns, own, motions.data() + own_.begin, n, parted.data(), columns, 0, to, c);
    };
    double *const to = g + parts_[p].first;
    times(parts_[p].motions, to);
    if (!of.complex) continue;
    times(parts_[p].imaginary, product.data());
    for (std::size_t q = 0; q < columns; ++q)
      for (std::size_t m = 0; m < c; ++m) {
        double &value = to[q * c + m];
        value = of.joined(static_cast<int>(q), value, product[of.partners[q] * c + m]);
      }
  }
}

void CoarseSpace::add(const double *g, double *v) const {
  const std::size_t w = layout_.width, n = layout_.dofs(), own = own_.size();
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    const IndexGroup &of = at_contacts_[p].of;
    const std::size_t columns = of.columns(), c = at_contacts_[p].count;
    const double *const from = g + parts_[p].first;
    std::vector<double> moved(own * columns), turned(of.complex ? c * columns : 0);
    gemm("T", "T", columns, own, c, from, c, parts_[p].motions.data() + own_.begin, n, 0, moved.data(), columns);
    for (std::size_t i = 0; i < turned.size(); ++i) turned[i] = of.turns[i / c] * from[of.partners[i / c] * c + i % c];
    if (of.complex)
      gemm("T", "T", columns, own, c, turned.data(), c, parts_[p].imaginary.data() + own_.begin, n, 1, moved.data(),
           columns);
    for (std::size_t j = 0; j < own; ++j)
      for (std::size_t q = 0; q < columns; ++q) v[j * w + of.coefficients[q]] += moved[j * columns + q];
  }
}

void CoarseSpace::solve(double *g, bool transposed) {
  rough_.assign(g, g + size_);
  jacobian_.solve(rough_.data(), transposed);
  each_harmonic([&](std::size_t, int k, double, std::size_t first) {
    part_.assign(g + first, g + first + diagonal_[k].size());
    diagonal_[k].solve(part_.data(), transposed);
    for (std::size_t i = 0; i < part_.size(); ++i) rough_[first + i] -= part_[i];
  });
  std::copy(rough_.begin(), rough_.end(), g);
}

} // namespace dovetail
