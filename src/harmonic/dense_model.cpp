#include "harmonic/dense_model.hpp"

#include <algorithm>
#include <type_traits>

#include "modal/dampers.hpp"
#include "support/error.hpp"
#include "support/gathered.hpp"
#include "support/shell.hpp"

namespace dovetail {
namespace {

// The values of all ranks, in rank order, on every rank.
template <class T> std::vector<T> all_of(MPI_Comm comm, const std::vector<T> &own) {
  static_assert(std::is_trivially_copyable_v<T>);
  MPI_Datatype one; // counted in bytes they would soon be too many
  MPI_Type_contiguous(sizeof(T), MPI_BYTE, &one);
  MPI_Type_commit(&one);
  std::vector<T> all = gathered(comm, one, own);
  MPI_Type_free(&one);
  return all;
}

} // namespace

DenseModel dense_model(const HarmonicSystem &system) {
  const Layout &layout = system.layout();
  const ScaledModel &scaled = system.scaled();
  DenseModel dense;
  dense.modes = static_cast<int>(layout.modes), dense.points = static_cast<int>(layout.points);
  const std::size_t n = dense.dofs();
  dense.K.resize(n * n), dense.M.resize(n * n);
  std::vector<PetscInt> place(n); // of each row of the harmonic system in the order of the results
  for (PetscInt i = 0; i < layout.dofs(); ++i)
    place[i < layout.modes ? layout.mode_row(i) : layout.contact_row(i - layout.modes)] = i;
  for (const Coupling &c : all_of(layout.comm, system.couplings())) {
    const std::size_t at = place[c.row] * n + place[c.column];
    dense.K[at] += c.k, dense.M[at] += c.m;
  }
  if (const Dampers *dampers = system.dampers(); dampers && dampers->is_viscous()) {
    dense.C.resize(n * n);
    for (const Dampers::Entry &c : all_of(layout.comm, dampers->entries()))
      dense.C[place[c.row] * n + place[c.column]] += c.viscous * system.setting().damping;
  }
  for (const LoadCase &load : system.loads()) {
    const auto contact = load.vector.begin() + layout.own_modes.size();
    LoadCase all{all_of(layout.comm, std::vector<double>(load.vector.begin(), contact)), load.fourier};
    const std::vector<double> fx = all_of(layout.comm, std::vector<double>(contact, load.vector.end()));
    all.vector.insert(all.vector.end(), fx.begin(), fx.end());
    for (double &f : all.fourier) f *= system.setting().load;
    dense.loads.push_back(std::move(all));
  }
  if (const std::vector<double> forces = all_of(layout.comm, system.constant()); !forces.empty()) {
    LoadCase constant{std::vector<double>(layout.modes, 0.0), {-2}}; // a load that is -1 in the mean, a0 / 2
    constant.vector.insert(constant.vector.end(), forces.begin(), forces.end());
    dense.loads.push_back(std::move(constant));
  }
  dense.file = scaled.model.reduced.file;
  dense.damping = system.damping();
  dense.contact = all_of(layout.comm, system.contact());
  dense.standstill = all_of(layout.comm, system.standstill());
  return dense;
}

std::vector<double> all_coefficients(const Layout &layout, Vec y) {
  const ReadValues values(y);
  const PetscInt modal = layout.own_modes.size() * layout.width;
  const std::vector<double> own_modal(values + 0, values + modal),
      own_contact(values + modal, values + layout.own_coefficients());
  std::vector<double> all = all_of(layout.comm, own_modal);
  const std::vector<double> contact = all_of(layout.comm, own_contact);
  all.insert(all.end(), contact.begin(), contact.end());
  return all;
}

void set_coefficients(const Layout &layout, const std::vector<double> &coefficients, Vec y) {
  const std::size_t width = layout.width, given = coefficients.size() / layout.dofs();
  const Values values(y);
  std::fill_n(values + 0, layout.own_coefficients(), 0.0);
  for (PetscInt d = 0; d < layout.own_dofs(); ++d)
    std::copy_n(&coefficients[layout.number(d) * given], std::min(given, width), values + d * width);
}

void pad(const Layout &from, Vec y, const Layout &to, Vec z) {
  const ReadValues old(y);
  const Values values(z);
  for (PetscInt d = 0; d < from.own_dofs(); ++d) {
    std::fill_n(values + d * to.width, to.width, 0.0);
    std::copy_n(old + d * from.width, std::min(from.width, to.width), values + d * to.width);
  }
  if (from.owns_omega()) values[to.own_coefficients()] = old[from.own_coefficients()];
}

} // namespace dovetail
