#include "problems/forced_response.hpp"

#include "problems/response_metric.hpp"
#include "support/error.hpp"

namespace dovetail {
namespace {

class ResponseJacobian : public BorderedJacobian {
public:
  explicit ResponseJacobian(HarmonicSystem &system) : system_(system), matrix_(system.matrix()) {}

  Mat matrix() const override { return matrix_; }
  void set_up(KSP ksp) override { system_.set_up(ksp, matrix_); }
  void assemble(Vec y, Vec border) override { system_.jacobian(y, border, matrix_); }
  int determinant_sign(KSP ksp) override { return system_.determinant_sign(ksp); }
  std::string recover(KSP ksp) override { return system_.recover(ksp, matrix_); }
  LinearEffort take_effort(int solves) override { return system_.take_effort(matrix_, solves); }
  double take_work() override { return system_.take_solver_work(matrix_); }
  double memory() const override { return system_.solver_memory(matrix_); }
  void begin(double memory, bool for_one) override { system_.begin_solves(matrix_, memory, for_one); }

private:
  HarmonicSystem &system_;
  UniqueMat matrix_;
};

} // namespace

std::unique_ptr<BorderedJacobian> ForcedResponse::jacobian() { return std::make_unique<ResponseJacobian>(system_); }

std::unique_ptr<ArcLengthMetric> ForcedResponse::metric(double unit, bool weighted) const {
  return std::make_unique<ResponseMetric>(system_.layout(), unit, weighted);
}

std::shared_ptr<PointData> ForcedResponse::describe() {
  auto data = std::make_shared<ResponseData>();
  data->activity = system_.activity();
  return data;
}

std::vector<Problem::Projected> ForcedResponse::own_projected(const std::vector<Vec> &of) const {
  const Layout &layout = system_.layout();
  if (directions_.empty())
    for (PetscInt d = 0; d < layout.own_dofs(); ++d)
      for (int i = 0; i < layout.width; ++i)
        for (int k = 1; k < projections; ++k) directions_.push_back(pseudo_random(layout.number(d), i, k));
  std::vector<Projected> all(of.size());
  for (std::size_t v = 0; v < of.size(); ++v) {
    const double *own, *direction = directions_.data();
    Projected &out = all[v];
    check(VecGetArrayRead(of[v], &own), "marking the way");
    for (PetscInt i = 0; i < layout.own_coefficients(); ++i)
      for (int k = 1; k < projections; ++k) out[k] += *direction++ * own[i];
    if (layout.owns_omega()) out[0] = own[layout.own_coefficients()];
    check(VecRestoreArrayRead(of[v], &own), "marking the way");
  }
  return all;
}

} // namespace dovetail
