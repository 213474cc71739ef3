#include "harmonic/sector_assembled.hpp"

#include <algorithm>
#include <cstdlib>
#include <utility>

#include "support/error.hpp"

namespace dovetail {
namespace {

std::vector<ComplexCoupling> complex(const std::vector<Coupling> &couplings) {
  std::vector<ComplexCoupling> out;
  for (const Coupling &c : couplings) out.push_back({c.row, c.column, c.k, c.m, c.stiff});
  return out;
}

template <class Number>
std::vector<CouplingOf<Number>> couplings_of(const Layout &layout, const std::vector<double> &kaa,
                                             const std::vector<Number> &mxa, const std::vector<Number> &mxx,
                                             const std::vector<Number> &kxx) {
  const std::size_t na = layout.modes, nc = 3 * layout.points;
  return list_couplings<Number>(layout, kaa, [&](PetscInt i) {
    return ContactRow<Number>{mxa.data() + i * na, mxx.data() + i * nc, kxx.data() + i * nc};
  });
}

} // namespace

SectorAssembled::SectorAssembled(const ReducedModel &model, const TravellingWave &wave, const Layout &layout,
                                 bool damps_mass)
    : AssembledForm(layout, damps_mass), wave_(wave) {
  auto couplings = std::make_shared<SectorCouplings>(wave.sectors / 2 + 1);
  (*couplings)[0] = complex(couplings_of(layout, model.kaa, model.mxa, model.mxx, model.kxx));
  for (int k = 1; k < wave.sectors; ++k) { // all that can occur, with whatever number of harmonics
    const int h = std::abs(wave.index(k));
    if (h == 0 || !(*couplings)[h].empty()) continue;
    const SectorIndex &of = model.indices[h - 1];
    (*couplings)[h] = couplings_of(layout, of.kaa, of.mxa, of.mxx, of.kxx);
  }
  couplings_ = std::move(couplings);
  build_products();
}

SectorAssembled::SectorAssembled(std::shared_ptr<const SectorCouplings> couplings, const TravellingWave &wave,
                                 const Layout &layout, bool damps_mass)
    : AssembledForm(layout, damps_mass), wave_(wave), couplings_(std::move(couplings)) {
  build_products();
}

std::unique_ptr<LinearPart> SectorAssembled::like(const Layout &layout) const {
  std::unique_ptr<SectorAssembled> other(new SectorAssembled(couplings_, wave_, layout, damps_mass_));
  share_dampers(*other);
  return other;
}

std::vector<Coupling> SectorAssembled::couplings() const { throw ComputeError(other_in_every_harmonic); }

// Of its factors: the modes one by one, then the contact points, which all meet. In operations in single precision.
void SectorAssembled::fill(Mat J, const JacobianParts &parts) {
  AssembledForm::fill(J, parts);
  const double harmonics = layout_.width / 2, modes = layout_.modes, nc = 3.0 * layout_.points,
               all = nc * layout_.width;
  work_ += 2 * (4 * modes * harmonics * 4 * nc * nc + 2.0 / 3 * all * all * all);
}

double SectorAssembled::take_work(Mat) const { return std::exchange(work_, 0.0); }

template <class Visit> void SectorAssembled::for_each(Visit &&visit) const {
  for (int k = 0; k <= layout_.width / 2; ++k) {
    const int h = wave_.index(k);
    for (const ComplexCoupling &c : (*couplings_)[std::abs(h)]) visit(k, c, h < 0 ? -1 : 1, h != 0);
  }
}

void SectorAssembled::build_products() {
  EntryPlaces stiff, heavy;
  std::vector<double> k_values, m_values;
  const int n = layout_.width;
  for_each([&](int k, const ComplexCoupling &coupling, int sign, bool turned) {
    const PetscInt i = coupling.row * n, j = coupling.column * n;
    const auto put = [&](EntryPlaces &places, std::vector<double> &values, std::complex<double> value) {
      if (k == 0) {
        places.add(i, j), values.push_back(value.real());
        return;
      }
      places.add(i + cosine(k), j + cosine(k)), values.push_back(value.real());
      places.add(i + sine(k), j + sine(k)), values.push_back(value.real());
      if (!turned) return;
      places.add(i + cosine(k), j + sine(k)), values.push_back(sign * value.imag());
      places.add(i + sine(k), j + cosine(k)), values.push_back(-sign * value.imag());
    };
    put(heavy, m_values, coupling.m);
    if (coupling.stiff) put(stiff, k_values, coupling.k);
  });
  stiffness_ = spread_matrix(layout_, n, std::move(stiff), k_values);
  mass_ = spread_matrix(layout_, n, std::move(heavy), m_values);
}

void SectorAssembled::multiply(const double *q, double *stiffness_force, double *inertia_force) {
  multiply_by(stiffness_, mass_, q, stiffness_force, inertia_force);
}

void SectorAssembled::place_structure(EntryPlaces &places) const {
  const int n = layout_.width;
  for_each([&](int k, const ComplexCoupling &c, int, bool turned) {
    const PetscInt i = c.row * n, j = c.column * n;
    if (k == 0) {
      if (c.stiff) places.add(i, j);
      return;
    }
    places.add(i + cosine(k), j + cosine(k)), places.add(i + sine(k), j + sine(k));
    if (c.stiff || turned || damps_mass_)
      places.add(i + cosine(k), j + sine(k)), places.add(i + sine(k), j + cosine(k));
  });
}

void SectorAssembled::write_structure(const DynamicStiffness &structure, std::vector<double> &values) const {
  for_each([&](int k, const ComplexCoupling &c, int sign, bool turned) {
    if (k == 0) {
      if (c.stiff) values.push_back(c.k.real());
      return;
    }
    const double ki = sign * c.k.imag(), mi = sign * c.m.imag();
    const double A = structure.in_phase(k, c.k.real(), c.m.real()) - structure.quadrature(k, ki, mi),
                 B = structure.in_phase(k, ki, mi) + structure.quadrature(k, c.k.real(), c.m.real());
    values.push_back(A), values.push_back(A);
    if (c.stiff || turned || damps_mass_) values.push_back(B), values.push_back(-B);
  });
}

void sector_loads(const ReducedModel &model, std::size_t pattern, const TravellingWave &wave, const Layout &layout,
                  std::vector<double> fourier, std::vector<LoadCase> &loads, std::vector<LoadCase> &left_out) {
  const LoadPattern &mean = model.loads[pattern];
  const int highest = static_cast<int>(fourier.size() / 2);
  const std::size_t modes = layout.own_modes.size(), width = coefficient_count(highest), own = layout.own_dofs();
  fourier.resize(width, 0.0);
  std::size_t most = model.left_out.squares.size(); // modes left out of any index
  for (const SectorIndex &index : model.indices) most = std::max(most, index.left_out.squares.size());
  for (int h = 0; h <= wave.sectors / 2; ++h) {
    std::vector<double> real(width), imaginary(width); // courses
    bool works = false;
    for (int k = 0; k <= highest; ++k) {
      const int index = wave.index(k);
      if (std::abs(index) != h) continue;
      if (k == 0) {
        real[0] = fourier[0];
      } else {
        const double a = fourier[cosine(k)], b = fourier[sine(k)];
        const int sign = index < 0 ? -1 : 1;
        real[cosine(k)] = a, real[sine(k)] = b;
        imaginary[cosine(k)] = sign * b, imaginary[sine(k)] = -sign * a;
      }
      works = works || (k == 0 ? fourier[0] != 0 : fourier[cosine(k)] != 0 || fourier[sine(k)] != 0);
    }
    if (!works) continue;
    const auto add = [&](std::size_t size, std::vector<LoadCase> &to, const auto &force) {
      LoadCase c{std::vector<double>(size), real}, s{std::vector<double>(size), imaginary};
      for (std::size_t d = 0; d < size; ++d) {
        const std::complex<double> value = force(d);
        c.vector[d] = value.real(), s.vector[d] = value.imag();
      }
      to.push_back(std::move(c));
      if (h != 0) to.push_back(std::move(s));
    };
    const SectorIndex *index = h > 0 ? &model.indices[h - 1] : nullptr;
    add(own, loads, [&](std::size_t d) -> std::complex<double> {
      const std::size_t mode = layout.own_modes.begin + d;
      if (index) return d < modes ? index->loads[pattern].fa[mode] : index->loads[pattern].fx[d - modes];
      return d < modes ? mean.fa[mode] : mean.fx[d - modes];
    });
    add(most, left_out, [&](std::size_t j) -> std::complex<double> {
      if (index) return j < index->left_out.squares.size() ? index->left_out.loads[pattern][j] : 0;
      return j < model.left_out.squares.size() ? model.left_out.loads[pattern][j] : 0;
    });
  }
}

} // namespace dovetail
