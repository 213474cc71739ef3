#pragma once
// Hill's method for a travelling wave on a cyclic structure: a small change of nodal shift n is sought in sector j as
//   exp(-2 pi i n j / N) exp(lambda t) p(t - j EO T / N),    p a sum of complex waves exp(i k Omega t),
// which makes one problem for every n, on one sector (docs/theory/stability.md). Wave k has the matrices of index
// k EO + n mod N, and the contact points answer as those of the sector do.
#include "harmonic/dampers.hpp"
#include "harmonic/sector_pencil.hpp"
#include "stability/complex_waves.hpp"
#include "support/complex_solve.hpp"

namespace dovetail {

/// The equations of a sector in every index, whole on every rank.
struct SectorEquations {
  int sectors = 0, engine_order = 0, modes = 0, points = 0;
  const std::vector<HermitianPencil> *of_index = nullptr; ///< (N/2 + 1) scaled, by |h|
  Damping damping;
  std::vector<double> C; ///< (3 points, 3 points) viscous, of the contact dofs besides; or empty

  int dofs() const { return modes + 3 * points; }
  /// h of that wave, -N/2 < h <= N/2.
  int index(int wave, int shift) const { return TravellingWave{sectors, 1}.index(wave * engine_order + shift); }
};

class SectorHill {
public:
  explicit SectorHill(const SectorEquations &equations) : equations_(equations) {} ///< must outlive it

  /// `blocks`: the answers() of the contact points with such waves; must outlive what is asked then.
  void assemble(int shift, const ComplexWaves &waves, double omega, const std::vector<std::complex<double>> &blocks,
                const std::vector<ContactPoint> &contact);

  struct Exponents {
    bool found = false;                       ///< false: the iteration did not converge
    std::vector<std::complex<double>> values; ///< lambda / Omega - i part, |Im| <= strip, of those not far from zero
    int diameter = -1;                        ///< of the fastest: that of its largest part
  };
  Exponents near_zero(double strip);

private:
  using Complex = std::complex<double>;
  struct Entry {
    Complex k, m, c;
  }; // of one wave: c = b k + a m + C

  Entry entry(int wave, int r, int c) const;
  Complex dynamic(Complex turn, const Entry &of) const { return of.k + turn * (of.c + turn * of.m); }
  Complex turn(int wave) const { return omega_ * Complex(shift_of_search, waves_->turns(wave)); }
  bool factor();
  void solve(Complex *b) const;
  void apply(const Complex *x, Complex *next) const;
  int diameter_of(const Complex *p) const;

  static constexpr double shift_of_search = 1e-3; // over Omega: the equations may be singular at 0

  const SectorEquations &equations_;
  const ComplexWaves *waves_ = nullptr;
  int shift_ = 0;
  double omega_ = 1;
  const std::vector<Complex> *blocks_ = nullptr;
  const std::vector<ContactPoint> *contact_ = nullptr;
  std::vector<Complex> pivots_, row_, column_; // (waves, modes) of the modes, and their couplings, (.., 3 points)
  ComplexFactors schur_;                       // of the contact dofs
};

} // namespace dovetail
