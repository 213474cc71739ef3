#include "contact/contact_forces.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

#include "contact/cone_law.hpp"
#include "contact/exact_law.hpp"
#include "contact/sampled_law.hpp"
#include "contact/samples.hpp"

namespace dovetail {

struct ContactForces::Laws { // those that some point needs
  std::optional<ExactLaw> exact;
  std::optional<SampledLaw> sampled;
  std::optional<ConeLaw> cone;
};

ContactForces::ContactForces(std::vector<ContactPoint> points, std::vector<Standstill> standstill, int harmonics,
                             int samples)
    : points_(std::move(points)), standstill_(std::move(standstill)), harmonics_(harmonics),
      laws_(std::make_unique<Laws>()), linear_(points_.size()), activity_(points_.size()) {
  for (int p = 0; p < size(); ++p) {
    const Law law = points_[p].law;
    if (law == Law::cone)
      cone_.push_back(p);
    else if (law != Law::bilateral)
      (takes_no_samples(samples) ? exact_ : sampled_).push_back(p);
    linear_[p].reset(harmonics);
  }
  if (!exact_.empty()) laws_->exact.emplace(harmonics);
  if (!sampled_.empty()) laws_->sampled.emplace(harmonics, samples);
  if (!cone_.empty()) laws_->cone.emplace(harmonics, samples_of_cones(samples, harmonics));
}

ContactForces::~ContactForces() = default;
ContactForces::ContactForces(ContactForces &&) noexcept = default;

void ContactForces::evaluate(const double *X, double *G, bool derivative) {
  const int width = 3 * coefficient_count(harmonics_);
  for (const int p : exact_)
    laws_->exact->evaluate(points_[p], standstill_[p], X + p * width, G + p * width, activity_[p], linear_[p]);
  if (!sampled_.empty())
    laws_->sampled->evaluate(sampled_.data(), static_cast<int>(sampled_.size()), points_.data(), standstill_.data(), X,
                             G, activity_.data(), derivative ? linear_.data() : nullptr);
  for (const int p : cone_)
    laws_->cone->evaluate(points_[p], standstill_[p], X + p * width, G + p * width, activity_[p],
                          derivative ? &linear_[p] : nullptr);
  for (int p = 0; p < size(); ++p) {
    const double *x = X + p * width;
    if (points_[p].law == Law::bilateral) linear_[p].multiply(points_[p], x, G + p * width);
    if (!std::all_of(x, x + width, [](double value) { return std::isfinite(value); })) // no law may swallow it
      std::fill_n(G + p * width, width, std::numeric_limits<double>::quiet_NaN());
  }
}

void ContactForces::change(std::vector<ContactPoint> points, std::vector<Standstill> standstill) {
  points_ = std::move(points), standstill_ = std::move(standstill);
}

void ContactForces::by_parameter(const double *X, const std::vector<EquivalentMotion> &equivalents,
                                 const std::vector<Memory> &memory, double *out) const {
  const int n = coefficient_count(harmonics_);
  std::vector<double> motion(3 * n), rubbed(3 * n);
  for (int p = 0; p < size(); ++p, X += 3 * n, out += 3 * n) {
    const Standstill &rest = standstill_[p];
    const EquivalentMotion &equivalent = equivalents[p];
    for (int d = 0; d < 3; ++d) {
      const double from = d < 2 ? rest.w[d] : points_[p].gap;
      for (int i = 0; i < n; ++i) motion[d * n + i] = equivalent.all[d] * X[d * n + i];
      motion[d * n] += 2 * (equivalent.all[d] * (rest.x[d] - from) + (d < 2 ? -memory[p][d] : equivalent.closing));
    }
    linear_[p].multiply(points_[p], motion.data(), out);
    if (equivalent.friction == std::array<double, 2>{}) continue;
    std::fill_n(motion.begin(), 2 * n, 0.0);
    std::copy_n(X + 2 * n, n, motion.begin() + 2 * n);
    motion[2 * n] += 2 * (rest.x[2] - points_[p].gap);
    linear_[p].multiply(points_[p], motion.data(), rubbed.data());
    for (int d = 0; d < 2; ++d)
      for (int i = 0; i < n; ++i) out[d * n + i] += equivalent.friction[d] * rubbed[d * n + i];
  }
}

std::vector<Graze> ContactForces::grazes(int p, const double *X) {
  if (std::find(exact_.begin(), exact_.end(), p) == exact_.end()) return {};
  std::vector<double> force(3 * coefficient_count(harmonics_));
  Activity activity;
  Linearisation linear = linear_[p];
  laws_->exact->evaluate(points_[p], standstill_[p], X, force.data(), activity, linear);
  return laws_->exact->grazes(points_[p], standstill_[p], X);
}

// The height depends on k_t (x_t - w_p) and mu k_n p alone, as the force does (contact_change.hpp).
double ContactForces::by_parameter(int p, const double *X, const Graze &graze, const EquivalentMotion &equivalent,
                                   const Memory &memory) const {
  const int n = coefficient_count(harmonics_), d = graze.direction;
  const Standstill &rest = standstill_[p];
  const double tangential = equivalent.all[d], normal = equivalent.all[2] + equivalent.friction[d];
  double sum = graze.by_t[0] * 2 * (tangential * (rest.x[d] - rest.w[d]) - memory[d]) +
               graze.by_n[0] * 2 * (normal * (rest.x[2] - points_[p].gap) + equivalent.closing);
  for (int i = 0; i < n; ++i) sum += tangential * graze.by_t[i] * X[d * n + i] + normal * graze.by_n[i] * X[2 * n + i];
  return sum;
}

ByParameter ContactForces::weighed(int p, const double *X, const double *weights) const {
  const int n = coefficient_count(harmonics_);
  const Standstill &rest = standstill_[p];
  const double from[] = {rest.w[0], rest.w[1], points_[p].gap};
  std::vector<double> motion(3 * n), force(3 * n);
  const auto rows = [&](int first, int last) {
    return std::inner_product(force.begin() + first * n, force.begin() + last * n, weights + first * n, 0.0);
  };
  ByParameter out;
  for (int d = 0; d < 3; ++d) {
    std::fill(motion.begin(), motion.end(), 0.0);
    std::copy_n(X + d * n, n, motion.begin() + d * n);
    motion[d * n] += 2 * (rest.x[d] - from[d]);
    linear_[p].multiply(points_[p], motion.data(), force.data());
    (d < 2 ? out.tangential_stiffness[d] : out.normal_stiffness) = rows(0, 3);
    for (int e = 0; d == 2 && e < 2; ++e) out.friction[e] = rows(e, e + 1);
  }
  std::fill(motion.begin(), motion.end(), 0.0);
  motion[2 * n] = -2;
  linear_[p].multiply(points_[p], motion.data(), force.data());
  out.gap = rows(0, 3);
  if (points_[p].law == Law::cone) out.friction = {out.friction[0] + out.friction[1], 0}; // one slider, one friction
  return out;
}

void ContactForces::multiply(const double *V, double *out) const {
  const int width = 3 * coefficient_count(harmonics_);
  for (int p = 0; p < size(); ++p) linear_[p].multiply(points_[p], V + p * width, out + p * width);
}

} // namespace dovetail
