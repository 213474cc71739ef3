#pragma once
// All contact points of a small model over one period of a motion, evaluated exactly.
#include <memory>
#include <optional>

#include "contact/cone_law.hpp"
#include "harmonic/dense_model.hpp"
#include "stability/waves.hpp"

namespace dovetail {

class ContactReading {
public:
  ContactReading(const DenseModel &model, int harmonics); ///< `model` must outlive it

  int harmonics() const { return harmonics_; }
  /// coefficients (n, 2H+1) of the whole motion.
  void read(const std::vector<double> &coefficients);

  /// Of the motion read last.
  const ContactHistory &history() const { return writer_.history(); }
  const Linearisation &linear(int point) const { return linear_[point]; }
  const std::vector<double> &force() const { return force_; } ///< (points, 3, 2H+1)
  /// What Hill's method takes: blocks of all points one after the other, by write_waves for waves up to `harmonics` (at
  /// most those read). If sampled(), whole waves and the harmonics read only.
  std::vector<double> answers(Waves waves, int harmonics, double lag = 0) const;
  /// Some point of law cone slips or opens: it is sampled, its linearisation dense, and `history` does not know it.
  bool sampled() const { return sampled_; }

private:
  const DenseModel &model_;
  int harmonics_;
  ExactLaw law_;
  std::optional<ConeLaw> cone_; // made when needed
  HistoryWriter writer_;
  std::vector<Linearisation> linear_;
  std::vector<double> force_;
  bool sampled_ = false;
};

} // namespace dovetail
