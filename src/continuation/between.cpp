#include "continuation/between.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace dovetail {
namespace {

constexpr double alike = 8;  // of fourth derivatives: up to this quotient
constexpr double most = 0.5; // of what the middle point is off, where they are not

// The cubic with these ends, `length` apart, at a part of the way.
Amplitude cubic(const Amplitude &from, const Amplitude &to, double length, double part) {
  const double left = 1 - part;
  return {left * left * (from.value * (1 + 2 * part) + length * from.slope * part) +
              part * part * (to.value * (3 - 2 * part) - length * to.slope * left),
          6 * part * left * (to.value - from.value) / length + left * (1 - 3 * part) * from.slope +
              part * (3 * part - 2) * to.slope};
}

} // namespace

void BetweenPoints::begin(const Amplitude &here) {
  here_ = here, known_ = 1;
  largest_ = std::max(largest_, here.value);
}

double BetweenPoints::add(double step, const Amplitude &next) {
  largest_ = std::max(largest_, next.value);
  const double bend = (next.slope - here_.slope) / step;
  double found = std::numeric_limits<double>::quiet_NaN();
  if (known_ > 1) {
    const Amplitude on = cubic(before_, next, step_ + step, step_ / (step_ + step));
    const double off = here_.value - on.value, fourth = off / std::pow(step_ * step, 2);
    const double askew = std::abs(here_.slope - on.slope - 2 * off * (1 / step_ - 1 / step)) * step;
    const bool smooth =
        known_ > 2 && askew < std::abs(off) && alike * fourth * fourth_ >= std::max(fourth * fourth, fourth_ * fourth_);
    found = std::abs(off) * std::pow(step / step_, 2) / 16;
    if (!smooth) {
      double jump = std::abs(bend - bend_here_);
      if (known_ > 2) jump = std::min(jump, std::abs(bend - bend_before_));
      found = std::max(found, std::min(jump * step * step / 8, most * std::max(std::abs(off), askew)));
    }
    found = largest_ > 0 ? found / largest_ : 0;
    fourth_ = fourth;
  }
  before_ = here_, here_ = next, step_ = step;
  bend_before_ = bend_here_, bend_here_ = bend;
  known_ = std::min(known_ + 1, 3);
  return found;
}

void BetweenPoints::archive(Archive &archive) {
  archive.field("before_value", before_.value);
  archive.field("before_slope", before_.slope);
  archive.field("here_value", here_.value);
  archive.field("here_slope", here_.slope);
  archive.field("step", step_);
  archive.field("fourth", fourth_);
  archive.field("bend_before", bend_before_);
  archive.field("bend_here", bend_here_);
  archive.field("largest", largest_);
  archive.field("known", known_);
}

} // namespace dovetail
