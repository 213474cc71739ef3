#pragma once
// What the diagonal D, the preconditioner of GMRES in the modes of the stuck structure, does not know of the contacts
// (docs/theory/stuck-modes.md): the Jacobian J among few motions B of the whole structure, in single precision,
//     P^-1 = D^-1 + B { (B^H J B)^-1 - (B^H D B)^-1 } B^H.
// B are the lowest modes, to which a harmonic of the excitation comes near, and the shapes of the joint without their
// part in these (joint_shapes.hpp), of each basis with all its harmonics. Every rank factors and solves the same.
#include "modal/modal_operator.hpp"
#include "modal/rough_factors.hpp"

namespace dovetail {

class CoarseSpace {
public:
  /// `bases` must outlive this.
  CoarseSpace(const StuckBases &bases, const Layout &layout, const ModalShare &share);

  bool used() const { return most_ > 0; }
  /// Of the Jacobian that `contacts` has taken: this rank's part of its matrix, for the sum of all ranks' to be
  /// factored.
  std::vector<float> part(const ModalOperator &contacts, const DynamicStiffness &structure);
  void factor(std::vector<float> matrix, const DynamicStiffness &structure);
  void forget() { sign_ = 0; }
  PetscInt size() const {
    return sign_ == 0 ? 0 : size_;
  } ///< unknowns, as ModalOperator::among; 0: nothing is factored
  /// g (size) = this rank's part of B^H times v (own modal unknowns).
  void to_motions(const double *v, double *g) const;
  /// g = { (B^H J B)^-1 - (B^H D B)^-1 } g.
  void solve(double *g, bool transposed);
  /// v += B g.
  void add(const double *g, double *v) const;
  int sign() const { return sign_ == 0 ? 1 : sign_; } ///< of the determinant of P, but for that of D

private:
  struct Products { // (count, count) of motions, in B^H diag B
    std::vector<double> real, imaginary;
  };
  struct Part { // harmonics that share a basis
    const StuckBasis &basis;
    PetscInt lowest = -1;                         // modes among the motions
    std::size_t first = 0;                        // unknown
    std::vector<double> motions, imaginary;       // (n, count) by columns
    Products stiff, heavy, damped, rates, losses; // of Lambda, 1, diag(Phi^H K Phi), the dampers' diagonal
  };
  void choose(double omega);
  void choose(PetscInt lowest, PetscInt shapes, std::size_t number);
  struct Blocks { // [A B; -B A] on cosine and sine
    double A, B;
  };
  Blocks blocks(const DynamicStiffness &structure, const Part &of, const Products &damped, int k, double sign,
                std::size_t at) const;
  void factor_diagonal(const DynamicStiffness &structure);
  template <class Work> void each_harmonic(Work &&work) const; // (part, harmonic, sign of its index, first unknown)

  Layout layout_;
  Range own_;          // modal unknowns
  PetscInt most_;      // motions of a basis at most; 0: the space is not used
  bool given_ = false; // that number of modes, by an option
  std::vector<Part> parts_;
  std::vector<ModalOperator::Motions> at_contacts_; // of each part
  PetscInt size_ = 0;
  RoughFactors jacobian_;
  std::vector<RoughFactors> diagonal_; // by harmonic: cosines of all motions, then sines
  std::vector<float> rough_, part_;
  int sign_ = 0;
};

} // namespace dovetail
