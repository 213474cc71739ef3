#include "reduction/sector_elastic.hpp"

#include <algorithm>

#include "support/gathered.hpp"

namespace dovetail {

FirstLevel first_level(ReducedModel &&model) {
  FirstLevel level;
  const MPI_Comm comm = model.comm;
  level.modes = model.modes, level.held = model.contact_dofs();
  level.squares = model.kaa;
  const auto take = [&](std::vector<double> &own) {
    std::vector<double> all = gathered(comm, MPI_DOUBLE, own);
    own = {};
    return all;
  };
  level.mass = take(model.mxx), level.stiffness = take(model.kxx), level.coupling = take(model.mxa);
  for (LoadPattern &load : model.loads) level.fa.push_back(load.fa), level.fx.push_back(take(load.fx));
  level.r = take(model.r);
  level.beyond = std::move(model.left_out), level.beyond.coupling = take(level.beyond.coupling);
  return level;
}

ElasticIndex elastic_index(const SectorCoordinates &E, const FirstLevel &first, const ComplexDense &K,
                           const ComplexDense &M, const ComplexDense &psi) {
  const int s = E.own(), nc = E.contact(), m = first.modes, r = static_cast<int>(first.beyond.squares.size()),
            n = m + s + r;
  const ComplexDense C = E.from_held(first.coupling.data(), m), B = E.from_held(first.beyond.coupling.data(), r);
  ElasticIndex out{first.squares,      first.beyond.squares, K.block(0, 0, s, s),
                   ComplexDense(n, n), ComplexDense(n, nc),  {}};
  const auto place = [&](int i) { return i < m ? i : s + i; }; // of interior modes, those left out behind
  for (int i = 0; i < m + r; ++i) {
    out.M(place(i), place(i)) = 1;
    for (int j = 0; j < s; ++j) {
      const std::complex<double> mass = i < m ? C(j, i) : B(j, i - m);
      out.M(m + j, place(i)) = mass, out.M(place(i), m + j) = std::conj(mass);
    }
    for (int j = 0; j < nc; ++j) out.carried(place(i), j) = std::conj(i < m ? C(s + j, i) : B(s + j, i - m));
  }
  for (int i = 0; i < m; ++i)
    for (int j = 0; j < r; ++j)
      out.M(i, m + s + j) = out.M(m + s + j, i) = first.beyond.with_modes[static_cast<std::size_t>(i) * r + j];
  for (int j = 0; j < s; ++j) std::copy_n(M.column(j), s, out.M.column(m + j) + m);
  for (int j = 0; j < nc; ++j) std::copy_n(M.column(s + j), s, out.carried.column(j) + m);
  const ComplexDense inertia = product(out.M.block(0, m, n, s), psi);
  for (std::size_t i = 0; i < inertia.values.size(); ++i) out.carried.values[i] += inertia.values[i];
  for (std::size_t j = 0; j < first.fx.size(); ++j) {
    const ComplexDense F = E.from_held(first.fx[j].data(), 1);
    out.loads.emplace_back(n, 1);
    std::complex<double> *load = out.loads.back().column(0);
    std::copy(first.fa[j].begin(), first.fa[j].end(), load);
    std::copy_n(F.column(0), s, load + m);
    if (r > 0) std::copy(first.beyond.loads[j].begin(), first.beyond.loads[j].end(), load + m + s);
  }
  return out;
}

} // namespace dovetail
