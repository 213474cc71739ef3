#include "app/check.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdio>

#include "app/hosts.hpp"
#include "case/undamped.hpp"
#include "contact/law_traits.hpp"
#include "stuck/resonances.hpp"
#include "support/error.hpp"

namespace dovetail {

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

namespace {

std::string percent(double share) { return number(100 * share) + " %"; }

double middle_of(const Case &study) { return (study.omega_from + study.omega_to) / 2; } // [rad/s]; 0: not known

// Everything that acts at a frequency, but for ratios of single modes.
double damping_ratio(const Damping &damping, double omega) {
  return (damping.stiffness * omega + damping.mass / omega + damping.structural) / 2;
}

void damping(const Case &study, std::vector<Warning> &out) {
  constexpr double little = 1e-3, much = 0.2; // of critical: steel, and what no structure of metal has
  const double omega = middle_of(study);
  if (omega <= 0) return; // a nonlinear mode, which wants no damping
  const std::string at = study.frequency_unit.text(omega, 4);
  if (undamped(study.damping))
    out.push_back(
        {"no_damping", "the case has no damping: where no contact point slips, nothing bounds the motion at a "
                       "resonance; damping.stiffness = " +
                           number(2 * little / omega) + " is " + percent(little) + " of critical at " + at});
  if (const double ratio = damping_ratio(study.damping, omega); ratio > much)
    out.push_back({"much_damping", "damping is " + percent(ratio) + " of critical at " + at +
                                       "; structures have 0.01 % to 5 %, and joints add theirs by friction. A damping "
                                       "ratio of " +
                                       percent(little) + " is damping.stiffness = " + number(2 * little / omega) +
                                       ", and 2 % of hysteretic damping damping.structural = 0.02"});
}

void harmonics(const Case &study, const std::vector<ContactPoint> &contact, std::vector<Warning> &out) {
  constexpr int odd = 3; // friction answers harmonic k with k, 3 k, 5 k ...
  const std::vector<int> driving = driving_harmonics(study.loads);
  const bool bends = std::any_of(contact.begin(), contact.end(),
                                 [](const ContactPoint &p) { return may_open(p.law) || has_friction(p.law); });
  if (study.tolerance > 0 || driving.empty() || !bends || study.harmonics >= odd * driving.back()) return;
  out.push_back({"few_harmonics", "harmonic_balance.harmonics = " + std::to_string(study.harmonics) +
                                      ", and the load works in harmonic " + std::to_string(driving.back()) +
                                      ": friction answers it with harmonic " + std::to_string(odd * driving.back()) +
                                      " above all, which is left out; write at least that many"});
}

void ranks(int ranks, const std::vector<ContactPoint> &contact, std::vector<Warning> &out) {
  const std::string idle = idle_ranks(ranks, static_cast<int>(contact.size()));
  if (!idle.empty()) out.push_back({"idle_ranks", idle});
}

// Own stiffness of the structure against motions of its contact dofs, all others held: (3 N_x), on every rank.
std::vector<double> stiffness_at_contact(const FullModel &model) {
  UniqueVec diagonal;
  PetscInt first, last;
  const PetscScalar *own;
  check(MatCreateVecs(model.K, diagonal.out(), nullptr), "looking at the diagonal of K");
  check(MatGetDiagonal(model.K, diagonal), "looking at the diagonal of K");
  check(VecGetOwnershipRange(diagonal, &first, &last), "looking at the diagonal of K");
  check(VecGetArrayRead(diagonal, &own), "looking at the diagonal of K");
  const auto of = [&](PetscInt dof) { return first <= dof && dof < last ? own[dof - first] : 0.0; };
  std::vector<double> out;
  for (const auto &dofs : model.contact_dofs)
    for (const PetscInt dof : dofs) out.push_back(of(dof));
  for (const CyclicSector::Contact &point : model.cyclic.contacts) { // of a pair, both sides in a row
    const double share = (point.has_a() && point.has_b() ? 0.25 : 1.0) / 3;
    double sum = 0;
    for (const CyclicSector::Node *node : {&point.a, &point.b})
      for (const PetscInt dof : *node) sum += share * of(dof);
    out.insert(out.end(), 3, sum);
  }
  check(VecRestoreArrayRead(diagonal, &own), "looking at the diagonal of K");
  MPI_Allreduce(MPI_IN_PLACE, out.data(), static_cast<int>(out.size()), MPI_DOUBLE, MPI_SUM, model.comm);
  return out;
}

std::vector<double> stiffness_at_contact(const ReducedModel &model) {
  std::vector<double> out(model.contact_dofs(), 0.0);
  const PetscInt first = 3 * model.own_points.begin;
  for (PetscInt i = 0; i < model.own_contact_dofs(); ++i)
    out[first + i] = model.kxx[i * model.contact_dofs() + first + i];
  MPI_Allreduce(MPI_IN_PLACE, out.data(), static_cast<int>(out.size()), MPI_DOUBLE, MPI_SUM, model.comm);
  return out;
}

void contact_stiffness(const std::vector<double> &structure, const std::vector<ContactPoint> &contact,
                       const Units &units, std::vector<Warning> &out) {
  constexpr double softest = 1e-4, stiffest = 1e3; // of the structure's
  if (structure.size() != 3 * contact.size()) return;
  struct Span {
    double low = INFINITY, high = 0, of_low = 0, of_high = 0; // springs over the structure, and the springs
    void take(double spring, double own) {
      if (spring <= 0 || own <= 0) return;
      if (spring / own < low) low = spring / own, of_low = spring;
      if (spring / own > high) high = spring / own, of_high = spring;
    }
  } normal, tangential;
  for (std::size_t p = 0; p < contact.size(); ++p) {
    normal.take(contact[p].kn, structure[3 * p + 2]);
    for (int d = 0; d < 2; ++d) tangential.take(contact[p].kt[d], structure[3 * p + d]);
  }
  const std::string unit = units.instead_of("N/m").empty() ? "" : " " + units.instead_of("N/m");
  const auto tell = [&](const char *key, double ratio, double spring, const char *means) {
    out.push_back({"contact_stiffness", std::string(key) + " = " + number(spring) + unit + " is " + number(ratio) +
                                            " times the stiffness of the structure at that point, " +
                                            number(spring / ratio) + unit + "; sensible is " + number(softest) +
                                            " to " + number(stiffest) +
                                            " times, and 0.1 to 10 where nothing was "
                                            "measured. " +
                                            means});
  };
  for (const auto &[key, span] :
       {std::pair("contact.normal_stiffness", normal), std::pair("contact.tangential_stiffness", tangential)}) {
    if (span.high > stiffest)
      tell(key, span.high, span.of_high, "Such a spring holds like a rigid one, and costs many harmonics");
    if (span.high > 0 && span.low < softest) tell(key, span.low, span.of_low, "Such a spring joins nothing");
  }
}

bool presses_by_gap(const std::vector<ContactPoint> &contact) {
  return std::any_of(contact.begin(), contact.end(),
                     [](const ContactPoint &point) { return !may_open(point.law) || point.gap < 0; });
}

} // namespace

std::vector<Warning> doubts_of_case(const Case &study, const std::vector<ContactPoint> &contact, int ranks_in_all) {
  std::vector<Warning> out;
  damping(study, out);
  harmonics(study, contact, out);
  ranks(ranks_in_all, contact, out);
  return out;
}

std::vector<Warning> doubts_of_model(const FullModel &model, const Case &study,
                                     const std::vector<ContactPoint> &contact) {
  std::vector<Warning> out = doubts_of_units(model);
  contact_stiffness(stiffness_at_contact(model), contact, study.units, out);
  PetscReal preload;
  check(VecNorm(model.preload, NORM_INFINITY, &preload), "looking at the preload");
  if (preload == 0 && !contact.empty() && !presses_by_gap(contact))
    out.push_back({"not_pressed", "nothing presses the joint: " + model.file.string() +
                                      " has no force other than zero in /preload, and no contact.gap is negative, an "
                                      "interference"});
  return out;
}

namespace {

// Twice that of modes under constant forces.
template <class Number> double energy(const std::vector<Number> &forces, const std::vector<double> &squares) {
  double sum = 0;
  for (std::size_t i = 0; i < squares.size(); ++i) sum += std::norm(forces[i]) / squares[i];
  return sum;
}

} // namespace

std::vector<Warning> doubts_of_reduced(const ReducedModel &model, const Case &study,
                                       const std::vector<ContactPoint> &contact) {
  constexpr double most = 0.5; // of the static motion under the load, with the contact points held
  std::vector<Warning> out;
  contact_stiffness(stiffness_at_contact(model), contact, study.units, out);
  const std::vector<int> driving = driving_harmonics(study.loads);
  const int h = std::abs(study.wave(model.sectors).index(driving.empty() ? 1 : driving.front()));
  for (std::size_t j = 0; j < model.loads.size() && !model.left_out.loads.empty(); ++j) {
    const auto is = [&](const LoadCourse &load) { return load.pattern == model.loads[j].name; };
    if (std::none_of(study.loads.begin(), study.loads.end(), is)) continue;
    const SectorIndex *index = h > 0 ? &model.indices[h - 1] : nullptr;
    const double kept = index ? energy(index->loads[j].fa, index->kaa) : energy(model.loads[j].fa, model.kaa),
                 lost = index ? energy(index->left_out.loads[j], index->left_out.squares)
                              : energy(model.left_out.loads[j], model.left_out.squares);
    if (lost > most * (kept + lost))
      out.push_back({"load_left_out", "of what the load \"" + model.loads[j].name +
                                          "\" moves at rest, contact points "
                                          "held, " +
                                          percent(lost / (kept + lost)) +
                                          " of the energy lies in modes that "
                                          "are left out; more reduction.modes than " +
                                          std::to_string(model.modes) + ", or reduction.kind = \"residual\", keep it"});
  }
  return out;
}

} // namespace dovetail
