#include "contact/contact_forces.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
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

void ContactForces::multiply(const double *V, double *out) const {
  const int width = 3 * coefficient_count(harmonics_);
  for (int p = 0; p < size(); ++p) linear_[p].multiply(points_[p], V + p * width, out + p * width);
}

} // namespace dovetail
