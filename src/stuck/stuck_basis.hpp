#pragma once
// The modes of the structure with all contact points stuck (docs/theory/stuck-modes.md): K_s Phi = M Phi diag(lambda)
// with K_s = K + K_t, K_t the springs of closed and stuck contacts, and Phi^T M Phi = 1. One basis for every frequency
// and every harmonic, because K = K_s - K_t differs from K_s on the contact dofs' diagonal only. With no springs they
// are those of the structure without contacts. On a sector one basis for each |h|, complex, but for h = 0.
#include <cstdlib>
#include <memory>

#include "case/damping.hpp"
#include "case/travelling_wave.hpp"
#include "contact/contact_point.hpp"
#include "scaling/dynamic_stiffness.hpp"
#include "stuck/layout.hpp"
#include "stuck/pencil_rows.hpp"
#include "stuck/slab.hpp"

namespace dovetail {

struct StuckBasis {
  std::vector<double> lambda;  ///< (n), n = N_a + 3 N_x, ascending; on every rank
  std::vector<double> damped;  ///< (n) diagonal of Phi^H K Phi; on every rank
  std::vector<double> rates;   ///< (n) diagonal of Phi^T C Phi of the dampers; on every rank
  std::vector<double> losses;  ///< (n) diagonal of Phi^T S Phi, likewise
  std::vector<double> springs; ///< (own contact dofs) K_t
  std::vector<double> shapes;  ///< (n, shapes) by columns, see joint_shapes.hpp; on every rank
  Slab<double> exact;          ///< (own dofs, n) Phi: rows of the own modes, then of the own contact dofs; complex
                               ///< (own dofs, 2n): real parts, then imaginary ones
  bool near = false;           ///< see near_basis.hpp: M is diagonal nearly, and there is no `exact`
  Slab<float> phi;             ///< the same
  Slab<float> viscous;         ///< (own modal unknowns, n) Phi^T C Phi without its diagonal; none if there is but that
  Slab<float> hysteretic;      ///< Phi^T S Phi likewise

  /// f(rows, stride, first, count) of the own dofs from `begin` on: Phi in double precision, if need be piece by piece.
  template <class F> void each_part(std::size_t begin, F f) const;

  bool dampers_are_diagonal() const { return viscous.columns() + hysteretic.columns() == 0; }
  /// What the dampers' diagonal adds to Q of mode j in harmonic k.
  double damper(const DynamicStiffness &structure, int k, std::size_t j) const {
    return structure.turn(k) * rates[j] + structure.hysteresis(k) * losses[j];
  }
};

template <class F> void StuckBasis::each_part(std::size_t begin, F f) const {
  constexpr std::size_t at_once = 256;
  const std::size_t rows = phi.rows(), n = phi.columns();
  if (!near) {
    if (rows > begin) f(exact.row(begin), exact.stride(), std::size_t(0), rows - begin);
    return;
  }
  std::vector<double> part(std::min(at_once, rows) * n);
  for (std::size_t first = begin; first < rows; first += at_once) {
    const std::size_t count = std::min(at_once, rows - first);
    for (std::size_t i = 0; i < count; ++i) std::copy_n(phi.row(first + i), n, &part[i * n]);
    f(static_cast<const double *>(part.data()), n, first - begin, count);
  }
}

/// The bases of all harmonics.
struct StuckBases {
  TravellingWave wave;
  std::vector<std::shared_ptr<const StuckBasis>> of_index; ///< (N/2 + 1) by |h|, those that harmonics have

  const StuckBasis &of(int harmonic) const { return *of_index[std::abs(wave.index(harmonic))]; }
  const StuckBasis &mean() const { return *of_index[0]; }
};

/// K plus springs on the contact dofs, and M: the own rows (own dofs, n). Those of modes have diagonals only, so M's
/// rows of the contact dofs hold the coupling.
struct Pencil {
  std::vector<double> K, M;
};
Pencil own_pencil(const PencilRows &rows, const std::vector<double> &springs, const Layout &layout);

/// With those springs, (own contact dofs). A dense eigenproblem of all n dofs, a large one on all ranks; solved already
/// if `rows` names a file that holds it. Collective.
/// InputError: M is not positive definite.
StuckBasis stuck_basis(const PencilRows &rows, std::vector<double> springs, const Layout &layout);
/// For the modal form: that, or of many dofs without dampers its substitute, near_basis.hpp. Collective. InputError
/// likewise.
StuckBasis modal_basis(const PencilRows &rows, std::vector<double> springs, const Layout &layout, bool dampers,
                       double reach);
/// Of some of a sector's indices h > 0, with their matrices, an index to a rank; the same list on all ranks.
/// Collective. InputError likewise.
std::vector<StuckBasis> stuck_bases(const ReducedModel &model, const std::vector<const SectorIndex *> &indices,
                                    const std::vector<double> &springs, const Layout &layout);

/// Those of all contacts closed and stuck.
std::vector<double> stuck_springs(const std::vector<ContactPoint> &contact);

/// 2 zeta sqrt(lambda) of a mode.
double rate_of(const StuckBasis &basis, const ModeRatio &ratio);

} // namespace dovetail
