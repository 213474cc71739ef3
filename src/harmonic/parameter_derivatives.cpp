// Derivatives of the equations of harmonic balance by parameters: of joint, loads, damping, and the frequency.
#include <numeric>

#include "contact/contact_derivative.hpp"
#include "harmonic/harmonic_system.hpp"
#include "support/error.hpp"
#include "support/shell.hpp"

namespace dovetail {
namespace {

// A coefficient of a motion or force times the imaginary unit, on cosine and sine; the mean has none.
double turned(const std::vector<double> &of, std::size_t i, int place) {
  return place == 0 ? 0 : place % 2 ? of[i + 1] : -of[i - 1];
}

} // namespace

std::vector<ByParameter> HarmonicSystem::weighed(Vec y, Vec weights) {
  const ReadValues q(y), w(weights);
  set(shared_parameter(q));
  evaluate_contact(q);
  std::vector<ByParameter> out;
  for (PetscInt p = 0; p < layout_.own_points.size(); ++p) {
    const PetscInt at = layout_.own_point_offset(p);
    out.push_back(forces_.weighed(static_cast<int>(p), q + at, w + at));
  }
  return out;
}

double HarmonicSystem::by_damping(std::size_t i) const {
  const int place = static_cast<int>(i % layout_.width), k = (place + 1) / 2;
  const DynamicStiffness one(scaled_.damping, setting_.omega);
  double sum = one.loss(k) * turned(of_.stiffness, i, place) + one.drag(k) * turned(of_.inertia, i, place);
  if (!of_.viscous.empty()) sum += one.turn(k) * turned(of_.viscous, i, place);
  if (!of_.hysteretic.empty()) sum += one.hysteresis(k) * turned(of_.hysteretic, i, place);
  return sum;
}

double HarmonicSystem::weighed_damping(Vec y, Vec weights) {
  const ReadValues q(y), w(weights);
  stand_at(q);
  double sum = 0;
  for (PetscInt i = 0; i < layout_.own_coefficients(); ++i) sum += w[i] * by_damping(i);
  MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_DOUBLE, MPI_SUM, layout_.comm);
  return sum;
}

void HarmonicSystem::by_parameter(Vec y, const PathParameter &by, Vec out) {
  const ReadValues q(y);
  if (by.changes_joint) { // by nothing else, and without products
    set(shared_parameter(q));
    evaluate_contact(q);
  } else {
    stand_at(q);
  }
  differentiate(q, by);
  check(VecSet(out, 0), "differentiating by a parameter");
  std::copy(column_.begin(), column_.end(), Values(out) + 0);
}

std::vector<std::vector<Graze>> HarmonicSystem::grazes(Vec y) {
  const ReadValues q(y);
  set(shared_parameter(q));
  std::vector<std::vector<Graze>> out;
  for (PetscInt p = 0; p < layout_.own_points.size(); ++p)
    out.push_back(forces_.grazes(static_cast<int>(p), q + layout_.own_point_offset(p)));
  return out;
}

double HarmonicSystem::by_parameter(Vec y, int own_point, const Graze &graze, const PathParameter &by) {
  if (!by.changes_joint) return 0;
  const ReadValues q(y);
  set(shared_parameter(q));
  const Setting slope = ResponseParameter(by).slope();
  const std::vector<Memory> &memory = preload_->memory_slope(setting_, slope);
  if (own_point < 0) return 0;
  return forces_.by_parameter(own_point, q + layout_.own_point_offset(own_point), graze,
                              preload_->equivalent(setting_, slope)[own_point], memory[own_point]);
}

void HarmonicSystem::by_frequency(const DynamicStiffness &structure, const Products &of, double *out) const {
  const int n = layout_.width;
  for (std::size_t i = 0; i < of.inertia.size(); ++i) {
    const int place = static_cast<int>(i % n), k = (place + 1) / 2;
    out[i] = -structure.inertia_slope(k) * of.inertia[i] + structure.loss_slope(k) * turned(of.stiffness, i, place) +
             structure.drag_slope(k) * turned(of.inertia, i, place);
    if (!of.viscous.empty()) out[i] += structure.turn_slope(k) * turned(of.viscous, i, place);
  }
}

void HarmonicSystem::differentiate_twice(Vec y, Vec along, double step, Vec weights, Vec out) {
  const ReadValues at(y), a(along), w(weights);
  const PetscInt own = layout_.own_coefficients(), first = layout_.own_point_offset(0);
  const double *q = at;
  stand_at(q);
  Products of;
  products(w, of);
  const Values to(out);
  by_frequency(structure(setting_.omega).transposed(), of, to);
  double by_omega = std::inner_product(a + 0, a + own, to + 0, 0.0);
  std::vector<double> moved(own), change(own);
  for (const double side : {1.0, -1.0}) { // of inertia the frequency's square
    by_frequency(structure(setting_.omega * (1 + side / 2)), change.data());
    by_omega += side * std::inner_product(change.begin(), change.end(), w + 0, 0.0) / setting_.omega;
  }
  for (const double side : {1.0, -1.0}) {                                        // of what is not linear
    for (PetscInt i = first; i < own; ++i) moved[i] = q[i] + side * step * a[i]; // of the contacts alone
    evaluate_contact(moved.data());
    ContactDerivative(forces_, true).multiply(w + first, change.data());
    for (PetscInt i = first; i < own; ++i) to[i] += side / (2 * step) * change[i - first];
  }
  MPI_Allreduce(MPI_IN_PLACE, &by_omega, 1, MPI_DOUBLE, MPI_SUM, layout_.comm);
  if (layout_.owns_omega()) to[own] = by_omega;
}

// At the motion q, whose products and contact forces are there.
void HarmonicSystem::differentiate(const double *q, const PathParameter &by) {
  const Setting slope = ResponseParameter(by).slope();
  column_.assign(layout_.own_coefficients(), 0.0);
  const int n = layout_.width;
  if (slope.omega != 0) by_frequency(structure(setting_.omega), column_.data()); // eq (13)
  for (std::size_t i = 0; i < column_.size() && slope.damping != 0; ++i) column_[i] += slope.damping * by_damping(i);
  for (std::size_t i = 0; i < column_.size() && slope.load != 0; ++i)
    column_[i] -= slope.load * force_coefficient(loads_, i / n, i % n);
  if (!by.changes_joint) return;
  const PetscInt first = layout_.own_point_offset(0);
  forces_.by_parameter(q + first, preload_->equivalent(setting_, slope), preload_->memory_slope(setting_, slope),
                       &column_[first]);
  const std::vector<double> &r = scaled_.model.reduced.r;
  for (std::size_t i = 0; i < r.size(); ++i) column_[first + i * n] += 2 * slope.preload * r[i];
}

} // namespace dovetail
