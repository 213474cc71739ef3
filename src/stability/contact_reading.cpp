#include "stability/contact_reading.hpp"

#include "contact/fourier.hpp"
#include "contact/law_traits.hpp"

namespace dovetail {

ContactReading::ContactReading(const DenseModel &model, int harmonics)
    : model_(model), harmonics_(harmonics), law_(harmonics), linear_(model.points),
      force_(static_cast<std::size_t>(3) * model.points * coefficient_count(harmonics)) {}

void ContactReading::read(const std::vector<double> &coefficients) {
  const int w = coefficient_count(harmonics_);
  writer_.begin();
  sampled_ = false;
  for (int p = 0; p < model_.points; ++p) {
    const ContactPoint &point = model_.contact[p];
    const double *X = &coefficients[static_cast<std::size_t>(model_.modes + 3 * p) * w];
    double *G = &force_[static_cast<std::size_t>(3) * p * w];
    Activity activity;
    if (!may_open(point.law)) {
      linear_[p].reset(harmonics_);
      linear_[p].springs_only = true;
      linear_[p].multiply(point, X, G);
      writer_.add_steady(point, true);
    } else if (shares_slider(point.law)) {
      if (!cone_) cone_.emplace(harmonics_, enough_samples(harmonics_));
      cone_->evaluate(point, model_.standstill[p], X, G, activity, &linear_[p]);
      linear_[p].springs_only = activity.open == 0 && activity.slip == 0;
      sampled_ = sampled_ || !(linear_[p].springs_only || activity.open == 1);
      writer_.add_steady(point, linear_[p].springs_only);
    } else {
      law_.evaluate(point, model_.standstill[p], X, G, activity, linear_[p]);
      if (law_.spans().empty())
        writer_.add_steady(point, linear_[p].springs_only);
      else
        writer_.add(point, law_);
    }
  }
  writer_.finish();
}

std::vector<double> ContactReading::answers(Waves waves, int harmonics, double lag) const {
  const int w = wave_coefficients(waves, harmonics);
  std::vector<double> blocks;
  for (int p = 0; p < model_.points; ++p) {
    const ContactPoint &point = model_.contact[p];
    const std::size_t at = blocks.size();
    blocks.resize(at + block_places(point.law).size() * w * w);
    if (sampled_ && shares_slider(point.law))
      linear_[p].write(point, &blocks[at]);
    else
      write_waves(waves, harmonics, point, linear_[p], history(), p, lag, &blocks[at]);
  }
  return blocks;
}

} // namespace dovetail
