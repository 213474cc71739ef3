#pragma once
// Factors of the bordered Jacobian in the modes of the stuck structure (modal_factors.hpp), where contacts stick for
// most of the time or few of them move: Delta = dG - kappa_k K_t of the points that do not stick all round.
// I + F Delta is dense, 2H+1 rows for each direction in which the law of such a point acts, and factored by LAPACK: in
// double precision, or where it is large in single. Of the points that stick only the damping is not that of the basis;
// its diagonal in the modes is in D, the rest, small, is not: what is solved with is exact if none sticks, and close
// otherwise.
#include "modal/modal_factors.hpp"
#include "modal/rough_factors.hpp"

namespace dovetail {

class ContactFactors : public ModalFactors {
public:
  /// `bases` must outlive this.
  ContactFactors(const StuckBases &bases, const Layout &layout) : ModalFactors(bases, layout) {}

  /// Looks at which points move at the Jacobian to come, or takes all of them to. Before factor(). `told`: how many of
  /// all ranks' contact dofs move, where that is known. Collective.
  void look_at(const ContactDerivative &contact, bool all, std::optional<double> told = {});
  /// How many of this rank's do.
  double own_moving(const ContactDerivative &contact);
  PetscInt size() const override { return rows_ * layout_.width; }
  double work() const override;
  double work_to_solve() const override;
  bool of_all() const { return points_ == layout_.points; } ///< points
  bool exact() const override { return of_all() && rough_.size() == 0 && basis_.dampers_are_diagonal(); }
  bool tells_sign() const override { return exact(); }

private:
  int decompose(const JacobianParts &parts, bool precisely) override;
  void react() override;
  void list_moving(const ContactDerivative &contact, bool all);
  void list_blocks();
  void gather_deltas(const JacobianParts &parts);
  void fill();

  PetscInt points_ = 0;                         // of which rows were factored
  std::vector<double> matrix_;                  // (size, size) I + F Delta, row-major, then its factors
  std::vector<double> in_phase_, out_of_phase_; // (rows, rows) F of one harmonic
  struct Block {                                // of Delta, between two rows that are of one point
    std::size_t row, column;
    bool acts; // not zero
  };
  std::vector<Block> blocks_;
  std::vector<double> delta_;        // (blocks, 2H+1, 2H+1)
  std::vector<double> written_;      // all blocks of one point
  RoughFactors rough_;               // the same in single precision, in its place if there are any
  std::vector<PetscBLASInt> pivots_; // (size)
  std::vector<float> rough_motion_;
};

} // namespace dovetail
