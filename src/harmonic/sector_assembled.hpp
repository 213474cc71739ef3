#pragma once
// The assembled form for a sector under a travelling wave: harmonic k has the Hermitian K and M of its index
// (docs/theory/cyclic-sectors.md). With K = K_r + i K_i and M alike, D_k = A + i B acts on cosine and sine as
//     [A B; -B A],    A = P(K_r, M_r) - Q(K_i, M_i),    B = P(K_i, M_i) + Q(K_r, M_r),
// P and Q as in DynamicStiffness.
#include "case/travelling_wave.hpp"
#include "harmonic/assembled_form.hpp"
#include "harmonic/load_case.hpp"

namespace dovetail {

class SectorAssembled : public AssembledForm {
public:
  /// Scaled, with the matrices of all indices. Collective.
  SectorAssembled(const ReducedModel &model, const TravellingWave &wave, const Layout &layout, bool damps_mass);
  std::unique_ptr<LinearPart> like(const Layout &layout) const override;
  void multiply(const double *q, double *stiffness_force, double *inertia_force) override;
  /// ComputeError: no one K and M is that of all harmonics.
  std::vector<Coupling> couplings() const override;
  void fill(Mat J, const JacobianParts &parts) override;
  double take_work(Mat J) const override;

protected:
  void place_structure(EntryPlaces &places) const override;
  void write_structure(const DynamicStiffness &structure, std::vector<double> &values) const override;

private:
  SectorAssembled(std::shared_ptr<const SectorCouplings> couplings, const TravellingWave &wave, const Layout &layout,
                  bool damps_mass);
  void build_products();
  /// visit(k, coupling, K_i and M_i have that sign, cosine and sine are coupled), harmonic by harmonic.
  template <class Visit> void for_each(Visit &&visit) const;

  TravellingWave wave_;
  std::shared_ptr<const SectorCouplings> couplings_; // this rank's
  UniqueMat stiffness_, mass_;                       // on all coefficients
  mutable double work_ = 0;                          // see take_work()
};

/// The loads of a pattern whose complex amplitude T_h^H F depends on the index: real vectors, each with a course.
/// (F_r + i F_i)(a - i b) is F_r with (a, b) and F_i with (b, -a). They join `loads`, by own dof, and, of modes left
/// out, `left_out`.
void sector_loads(const ReducedModel &model, std::size_t pattern, const TravellingWave &wave, const Layout &layout,
                  std::vector<double> fourier, std::vector<LoadCase> &loads, std::vector<LoadCase> &left_out);

} // namespace dovetail
