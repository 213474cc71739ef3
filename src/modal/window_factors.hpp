#pragma once
// Factors of the bordered Jacobian in the modes of the structure without any contact (modal_factors.hpp), where
// contacts are open for most of the time: Delta = dG sees of each motion only what few waves make of it (window.hpp),
// W^T, so that
//     Delta = W C W^T,    Delta (I + F Delta)^-1 = W C (I + W^T F W C)^-1 W^T,
// with C the part of dG that belongs to these waves. What is factored has as many rows as they are, in double
// precision.
#include "modal/modal_factors.hpp"
#include "modal/window.hpp"

namespace dovetail {

class WindowFactors : public ModalFactors {
public:
  /// `open`: modes of the structure without contacts, stuck_basis with no springs; must outlive this.
  WindowFactors(const StuckBases &open, const Layout &layout) : ModalFactors(open, layout) {}

  /// Looks at the windows of the Jacobian to come; factors of another are gone. False: a law has none, or the work
  /// would be more than it is worth. Collective.
  bool look_at(const ContactForces &contact, double worth);
  PetscInt size() const override { return static_cast<PetscInt>(size_); }
  double work() const override;
  double work_to_solve() const override;
  bool exact() const override { return false; }
  bool tells_sign() const override { return true; }

private:
  int decompose(const JacobianParts &parts, bool precisely) override;
  void react() override;
  bool plausible(const ContactForces &contact, double worth) const;
  void list_windows();
  void gather_deltas(const ContactForces &contact);
  void fill();

  std::vector<Window> own_;      // of the own points that are closed at times
  struct Place {                 // of a window, all ranks'
    std::size_t row, directions; // among the rows
    std::size_t rank, at;        // waves of each direction, and the first one's place among all
    std::size_t weights, delta;  // places in weights_ and deltas_
    std::size_t combinations() const { return directions * rank; }
  };
  std::vector<Place> windows_;                  // in the order of the points
  std::size_t size_ = 0;                        // waves, all told
  std::vector<double> weights_;                 // (rank, 2H+1) of each window
  std::vector<double> written_, half_;          // blocks of one point; F W of two rows
  std::vector<double> deltas_;                  // (combinations, combinations) C of each window
  std::vector<double> in_phase_, out_of_phase_; // (H+1, rows, rows) F
  std::vector<double> seen_;                    // (size, size) W^T F W
  std::vector<double> matrix_;                  // (size, size) I + W^T F W C, row-major, then its factors
  std::vector<PetscBLASInt> pivots_;
  std::vector<double> combined_, force_of_; // (size)
};

} // namespace dovetail
