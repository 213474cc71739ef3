#include "problems/mode_jacobian.hpp"

#include "support/mumps.hpp"

namespace dovetail {

ModeJacobian::ModeJacobian(NonlinearMode &mode, HarmonicSystem &system)
    : mode_(mode), system_(system), inner_(system.matrix()), border_(system.layout()) {
  const UniqueVec none = mode.unknowns();
  const std::vector<double> zero(system.layout().own_unknowns(), 0.0);
  mode_.evaluate(none);
  system_.fill(inner_, mode_.structure(), zero.data(), zero.data()); // to have its pattern
  matrix_ = std::make_unique<WiderMatrix>(system.layout(), inner_, ModeBorder::width - 1);
}

void ModeJacobian::set_up(KSP ksp) { factor_by_lu(ksp, matrix()); }
int ModeJacobian::determinant_sign(KSP ksp) { return dovetail::determinant_sign(ksp); }
std::string ModeJacobian::recover(KSP ksp) { return recover_lu(ksp, matrix()); }

void ModeJacobian::assemble(Vec y, Vec plane) {
  mode_.evaluate(y);
  border_.take(mode_, plane);
  auto [by_omega, by_ratio, by_lam] = border_.columns;
  auto [length, phase, across] = border_.rows;
  if (system_.layout().owns_omega()) { // Omega, in the row of the length
    for (auto *one : {&by_ratio, &by_lam, &length, &phase}) one->push_back(0);
    across.push_back(border_.corner.back()[0]);
  }
  system_.fill(inner_, mode_.structure(), by_omega.data(), length.data());
  const double corner[] = {0, 0, border_.corner.back()[1], border_.corner.back()[2]};
  matrix_->fill(inner_, {by_ratio.data(), by_lam.data()}, {phase.data(), across.data()}, corner,
                mode_.state().amplitude);
}

} // namespace dovetail
