#include "harmonic/harmonic_system.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>

#include "continuation/problem.hpp"
#include "harmonic/assembled.hpp"
#include "harmonic/dense_model.hpp"
#include "harmonic/sector_assembled.hpp"
#include "modal/dampers.hpp"
#include "modal/modal.hpp"
#include "support/error.hpp"
#include "support/event.hpp"
#include "support/shell.hpp"

namespace dovetail {
namespace {

std::unique_ptr<AssembledForm> assembled_part(const ReducedModel &model, const TravellingWave &wave,
                                              const Layout &layout, bool damps_mass) {
  if (wave.sectors > 0) return std::make_unique<SectorAssembled>(model, wave, layout, damps_mass);
  return std::make_unique<Assembled>(
      list_couplings<double>(
          layout, model.kaa,
          [&](PetscInt i) {
            const std::size_t at = i, nc = model.contact_dofs();
            return ContactRow<double>{model.mxa.data() + at * model.modes, &model.mxx[at * nc], &model.kxx[at * nc]};
          }),
      layout, damps_mass);
}

// All of a sector's indices but the loads.
std::vector<SectorIndex> taken_matrices(ReducedModel &model) {
  std::vector<SectorIndex> taken;
  for (SectorIndex &index : model.indices)
    taken.push_back({std::move(index.kaa), std::move(index.mxa), std::move(index.mxx), std::move(index.kxx), {}, {}});
  return taken;
}

std::unique_ptr<LinearPart> linear_part(PreloadedModel &preloaded, const TravellingWave &wave, const Damping &damping,
                                        const Layout &layout, LinearForm form, double reach) {
  ReducedModel &model = preloaded.reduced;
  const std::vector<ContactPoint> &contact = preloaded.contact;
  std::unique_ptr<LinearPart> part;
  if (form == LinearForm::modal)
    part = std::make_unique<Modal>(model, taken_matrices(model), wave, contact, preloaded.standstill, damping, layout,
                                   reach);
  else {
    auto assembled = assembled_part(model, wave, layout, DynamicStiffness(damping).damps_mass());
    if (damping.has_dampers()) {
      auto dampers = std::make_shared<Dampers>(model, contact, preloaded.standstill, damping, layout);
      if (damping.has_stuck_ratios())
        dampers->take_ratios(*assembled, stuck_basis(model, stuck_springs(contact), layout), damping.ratios);
      assembled->take(std::move(dampers));
    }
    part = std::move(assembled);
  }
  for (auto *rows : {&model.kxx, &model.mxx, &model.mxa}) std::vector<double>().swap(*rows); // the part holds it now
  if (form == LinearForm::modal) model.viscous = model.structural = {}; // the other form is made of these
  return part;
}

} // namespace

HarmonicSystem::HarmonicSystem(ScaledModel model, int harmonics, int samples, const std::vector<LoadCourse> &loads,
                               LinearForm form)
    : scaled_(std::move(model)), layout_(scaled_.model.reduced, harmonics), harmonics_(harmonics), samples_(samples),
      form_(form), loose_(scaled_.model.reduced, layout_),
      forces_(scaled_.model.contact, scaled_.model.standstill, harmonics, samples),
      linear_(linear_part(scaled_.model, wave(), scaled_.damping, layout_, form, scaled_.highest * harmonics)) {
  ReducedModel &reduced = scaled_.model.reduced;
  for (const LoadCourse &load : loads) {
    const std::size_t number = reduced.load(load.pattern);
    if (is_cyclic()) {
      sector_loads(reduced, number, wave(), layout_, load.fourier, loads_, left_out_loads_);
      continue;
    }
    const LoadPattern &pattern = reduced.loads[number];
    const auto modal = pattern.fa.begin() + layout_.own_modes.begin;
    loads_.push_back({{modal, modal + layout_.own_modes.size()}, load.fourier});
    loads_.back().vector.insert(loads_.back().vector.end(), pattern.fx.begin(), pattern.fx.end());
    if (!reduced.left_out.loads.empty()) left_out_loads_.push_back({reduced.left_out.loads[number], load.fourier});
  }
  for (SectorIndex &index : reduced.indices) // the linear part and the loads hold the rest now
    index = {{}, {}, {}, {}, {}, std::move(index.left_out)};
  fit_courses();
}

HarmonicSystem::HarmonicSystem(const HarmonicSystem &like, int harmonics, int samples)
    : scaled_(like.scaled_), layout_(scaled_.model.reduced, harmonics), harmonics_(harmonics), samples_(samples),
      form_(like.form_), loads_(like.loads_), left_out_loads_(like.left_out_loads_), loose_(like.loose_),
      parameter_(like.parameter_), preload_(like.preload_),
      forces_(scaled_.model.contact, scaled_.model.standstill, harmonics, samples),
      linear_(like.linear_->like(layout_)) {
  fit_courses();
}

void HarmonicSystem::fit_courses() {
  for (auto *loads : {&loads_, &left_out_loads_})
    for (LoadCase &load : *loads) load.fourier.resize(layout_.width, 0.0);
}

std::unique_ptr<HarmonicSystem> HarmonicSystem::modal(const HarmonicSystem &like, int harmonics, int samples) {
  auto system = std::make_unique<HarmonicSystem>(like, harmonics, samples);
  if (like.form_ == LinearForm::modal || like.is_cyclic()) return system;
  const DenseModel dense = dense_model(like);
  ReducedModel rows = like.scaled_.model.reduced; // with the matrices again, by rows of the own contact dofs
  const std::size_t n = dense.dofs(), modes = dense.modes, first = modes + 3 * rows.own_points.begin;
  for (std::size_t i = first; i < first + rows.own_contact_dofs(); ++i) {
    const double *m = &dense.M[i * n], *k = &dense.K[i * n];
    rows.mxa.insert(rows.mxa.end(), m, m + modes);
    rows.mxx.insert(rows.mxx.end(), m + modes, m + n);
    rows.kxx.insert(rows.kxx.end(), k + modes, k + n);
  }
  system->linear_ = std::make_unique<Modal>(rows, std::vector<SectorIndex>(), TravellingWave(),
                                            like.scaled_.model.contact, like.scaled_.model.standstill,
                                            like.scaled_.damping, system->layout_, like.scaled_.highest * harmonics);
  system->form_ = LinearForm::modal;
  return system;
}

UniqueVec HarmonicSystem::unknowns() const {
  UniqueVec y;
  check(VecCreateMPI(layout_.comm, layout_.own_unknowns(), layout_.unknowns(), y.out()), "creating the unknowns");
  check(VecSet(y, 0), "creating the unknowns");
  return y;
}

double HarmonicSystem::parameter_in(Vec y) const { return parameter_of(y); }

double HarmonicSystem::shared_parameter(const double *own) const {
  double value = layout_.owns_omega() ? own[layout_.own_coefficients()] : 0;
  MPI_Bcast(&value, 1, MPI_DOUBLE, layout_.size - 1, layout_.comm);
  return value;
}

void HarmonicSystem::vary(ResponseParameter parameter, std::shared_ptr<VariedPreload> preload) {
  parameter_ = parameter, preload_ = std::move(preload), value_.reset();
}

bool HarmonicSystem::set(double value) {
  if (value_ == value) return true;
  value_ = value, setting_ = parameter_.at(value);
  if (!parameter_.changes_joint()) return true;
  contact_.clear();
  const bool found = preload_->solve(setting_);
  if (found)
    forces_.change(preload_->contact(), preload_->standstill()), constant_ = preload_->constant();
  else
    value_.reset(), constant_.assign(3 * layout_.own_points.size(), std::numeric_limits<double>::quiet_NaN());
  return found;
}

bool HarmonicSystem::has_products(const double *q) const {
  return of_.motion.size() == static_cast<std::size_t>(layout_.own_coefficients()) &&
         std::equal(of_.motion.begin(), of_.motion.end(), q);
}

// Sets the parameter, makes the products and evaluates the contact, of unknowns y. Returns border . y. By one message,
// where the products take one.
double HarmonicSystem::go_to(const double *y, const double *border) {
  const double own = layout_.owns_omega() ? y[layout_.own_coefficients()] : 0;
  std::vector<double> sums{own, border ? std::inner_product(y, y + layout_.own_unknowns(), border, 0.0) : 0};
  if (layout_.size > 1 || !has_products(y)) products(y, of_, &sums);
  set(sums[0]);
  evaluate_contact(y);
  return sums[1];
}

// The same where the residual was evaluated last, most likely: by a short message, in which `more` is added up, too.
// False if it was not there.
bool HarmonicSystem::stand_at(const double *y, std::vector<double> *more) {
  const std::optional<double> before = value_;
  std::vector<double> sums{layout_.owns_omega() ? y[layout_.own_coefficients()] : 0, has_products(y) ? 0.0 : 1.0};
  if (more) sums.insert(sums.end(), more->begin(), more->end());
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), static_cast<int>(sums.size()), MPI_DOUBLE, MPI_SUM, layout_.comm);
  if (more) more->assign(sums.begin() + 2, sums.end());
  set(sums[0]);
  const bool there = sums[1] == 0 && value_ == before;
  if (sums[1] > 0) products(y, of_);
  evaluate_contact(y);
  return there;
}

// With `sums`, they become those over all ranks.
void HarmonicSystem::products(const double *q, Products &of, std::vector<double> *sums) {
  const std::size_t count = layout_.own_coefficients();
  of.stiffness.resize(count), of.inertia.resize(count);
  const Timed timed(Work::matrices);
  if (sums)
    linear_->multiply_and_share(q, of.stiffness.data(), of.inertia.data(), *sums, layout_.comm);
  else
    linear_->multiply(q, of.stiffness.data(), of.inertia.data());
  if (const Dampers *dampers = linear_->dampers()) {
    if (dampers->is_viscous()) of.viscous.resize(count), dampers->viscous_force(q, layout_.width, of.viscous.data());
    if (dampers->is_hysteretic())
      of.hysteretic.resize(count), dampers->hysteretic_force(q, layout_.width, of.hysteretic.data());
  }
  of.motion.assign(q, q + count);
}

void HarmonicSystem::evaluate_contact(const double *q) {
  const double *contact = q + layout_.own_point_offset(0);
  const std::size_t count = layout_.own_points.size() * 3 * layout_.width;
  if (contact_.size() == count && std::equal(contact_.begin(), contact_.end(), contact)) return;
  force_.resize(count);
  const Timed timed(Work::contact);
  forces_.evaluate(contact, force_.data());
  contact_.assign(contact, contact + count);
}

void HarmonicSystem::evaluate(const double *q) {
  int same = has_products(q);
  MPI_Allreduce(MPI_IN_PLACE, &same, 1, MPI_INT, MPI_LAND, layout_.comm);
  if (!same) products(q, of_);
  evaluate_contact(q);
}

const double *HarmonicSystem::holding() {
  const Stiffness of = contact_stiffness();
  adrift_ = loose_.motions() > 0 && loose_.adrift(of.mean, of.springs);
  return hold_adrift(of);
}

void HarmonicSystem::balance(const DynamicStiffness &structure, double constant, double varying, double *out) const {
  const int n = layout_.width;
  const std::vector<double> &u = of_.stiffness, &v = of_.inertia;
  for (PetscInt d = 0; d < layout_.own_dofs(); ++d) {
    const PetscInt at = d * n;
    out[at] = u[at] - force_coefficient(loads_, d, 0, constant);
    for (int k = 1; k <= harmonics_; ++k) {
      const PetscInt c = at + cosine(k), s = at + sine(k);
      const double inertia = structure.inertia(k), loss = structure.loss(k), drag = structure.drag(k);
      out[c] = u[c] - inertia * v[c] + loss * u[s] + drag * v[s] - force_coefficient(loads_, d, cosine(k), varying);
      out[s] = u[s] - inertia * v[s] - loss * u[c] - drag * v[c] - force_coefficient(loads_, d, sine(k), varying);
      for (const auto &[damper, factor] :
           {std::pair(&of_.viscous, structure.turn(k)), {&of_.hysteretic, structure.hysteresis(k)}})
        if (!damper->empty()) out[c] += factor * (*damper)[s], out[s] -= factor * (*damper)[c];
    }
  }
  double *contact = out + layout_.own_point_offset(0);
  for (std::size_t i = 0; i < force_.size(); ++i) contact[i] += force_[i];
  for (std::size_t i = 0; i < constant_.size(); ++i) contact[i * n] += 2 * constant_[i];
}

double HarmonicSystem::residual(Vec y, Vec f, Vec border) {
  const ReadValues q(y);
  const double along = border ? go_to(q, ReadValues(border)) : go_to(q, nullptr);
  balance(structure(setting_.omega), setting_.load, setting_.load, Values(f));
  return along;
}

void HarmonicSystem::jacobian(Vec y, Vec border, Mat J) {
  const ReadValues q(y), last(border);
  evaluate_contact(q);
  const Stiffness of = contact_stiffness();
  std::vector<double> sums = loose_.held(of.mean, of.springs);
  const std::size_t held_sums = sums.size();
  const std::vector<double> wanted = linear_->own_sums(J, ContactDerivative(forces_));
  sums.insert(sums.end(), wanted.begin(), wanted.end());
  const bool there = stand_at(q, &sums);
  if (there) linear_->take_sums(J, sums.data() + held_sums);
  differentiate(q, parameter_.kind());
  adrift_ = loose_.motions() > 0 && there && loose_.adrift(sums.data());
  const double *held = there ? hold_adrift(of) : holding();
  linear_->fill(J, {structure(setting_.omega), ContactDerivative(forces_), held, column_.data(), last});
}

void HarmonicSystem::transposed_jacobian(Vec y, Vec border, Mat J) {
  const ReadValues q(y), last(border);
  stand_at(q);
  differentiate(q, parameter_.kind());
  if (layout_.owns_omega()) column_.push_back(last[layout_.own_coefficients()]);
  const double *held = holding();
  linear_->fill(J,
                {structure(setting_.omega).transposed(), ContactDerivative(forces_, true), held, last, column_.data()});
}

void HarmonicSystem::fill(Mat J, const DynamicStiffness &structure, const double *column, const double *border) {
  const double *held = holding();
  linear_->fill(J, {structure, ContactDerivative(forces_), held, column, border});
}

// Of the own contact dofs, where a rigid motion may be loose.
HarmonicSystem::Stiffness HarmonicSystem::contact_stiffness() const {
  Stiffness of;
  for (int p = 0; p < forces_.size() && loose_.motions() > 0; ++p) {
    const auto mean = forces_.mean_stiffness(p), stuck = stuck_springs(forces_.points()[p]);
    of.mean.insert(of.mean.end(), mean.begin(), mean.end());
    of.springs.insert(of.springs.end(), stuck.begin(), stuck.end());
  }
  return of;
}

// Part of each spring on the diagonal of the constant parts, where contact itself gives none; null if nothing is
// adrift.
const double *HarmonicSystem::hold_adrift(const Stiffness &of) {
  constexpr double part = 0.25; // separation of bodies tried by experiment: 1/4 comes back from several gaps' distance
  if (!adrift_) return nullptr;
  held_.assign(of.springs.size(), 0.0);
  for (std::size_t dof = 0; dof < of.springs.size(); ++dof)
    if (std::abs(of.mean[dof]) < 1e-6 * of.springs[dof]) held_[dof] = part * of.springs[dof];
  return held_.data();
}

} // namespace dovetail
