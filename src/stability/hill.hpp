#pragma once
// Hill's method: a small change of the periodic motion is sought as exp(lambda t) p(t), p a sum of waves, in the
// linearised equations of harmonic balance,
//   lambda^2 M p + lambda (C + 2 Omega M d/dtheta) p + J p = 0.
// On whole waves J is the Jacobian of harmonic balance, so that lambda passes zero exactly where that is singular. What
// sliders remember depends on lambda besides, J being its value for lambda = 0 (slider_memory.hpp).
#include <complex>

#include "harmonic/dense_model.hpp"
#include "stability/slider_memory.hpp"
#include "support/dense.hpp"

namespace dovetail {

/// The exponents of whole waves appear again and again, i Omega apart, and those of half waves in the middle between
/// them. In either case those near zero, |Im| <= Omega / 4, are the ones found best: together they are all.
class Hill {
public:
  explicit Hill(const DenseModel &model) : model_(model) {} ///< `model` must outlive it

  /// `blocks`: of all contact points one after the other, as write_waves gives them, for a lag of exponent_shift if
  /// sliders are to remember `holds`.
  void assemble(Waves waves, int harmonics, double omega, std::vector<double> blocks,
                const std::vector<ContactHistory::Hold> &holds = {});

  int size() const { return model_.dofs() * width_; }       ///< of p: (n, coefficients of the waves)
  void stiffness_times(const double *p, double *out) const; ///< J p
  void rate_times(const double *p, double *out) const;      ///< (C + 2 Omega M d/dtheta) p
  void mass_times(const double *p, double *out) const;      ///< M p

  struct Exponents {
    bool found = false;                       ///< false: the iteration did not converge
    std::vector<std::complex<double>> values; ///< over Omega, |Im| <= strip, of those not far from zero
    int steps = 0;                            ///< of Arnoldi's iteration
  };
  /// strip: at least 1/4; 1/2 makes whole waves find all exponents, with more effort.
  Exponents near_zero(double strip = 0.25);

private:
  /// `take`(row, column, values): the blocks of the contact points, rows and columns counted from the first of them.
  template <class Take> void for_each_block(Take take) const;
  std::complex<double> dynamic(double lambda, int i, int r, int c) const;
  int eliminated() const {
    return model_.C.empty() ? model_.modes : 0;
  } // dofs of factor(): modes, unless C couples them
  bool factor(double lambda);
  void solve(double *b) const;
  void look_at_ritz_values(int steps, double strip, Exponents &out);

  const DenseModel &model_;
  Waves waves_ = Waves::whole;
  int width_ = 0;
  double omega_ = 1;
  std::vector<double> blocks_;
  SliderMemory memory_;
  Dense basis_, hessenberg_;
  std::vector<std::complex<double>> inverse_,
      coupling_;  // of factor(): (waves, eliminated), (waves, eliminated, others)
  Factors schur_; // of the other dofs
};

} // namespace dovetail
