#pragma once
// Harmonics to a tolerance: added before a point is accepted whose estimated error is larger, dropped where fewer do.
// Without a tolerance, those go again that recovery added.
#include <functional>

#include "analyses/error_watch.hpp"

namespace dovetail {

class HarmonicsControl {
public:
  /// Moves the point where the curve stands to so many harmonics, within so many iterations, unless 0. False: nothing
  /// has changed. `error`: with the harmonics before.
  using Change = std::function<bool(int harmonics, int most_newton, double error)>;

  /// `unit`: range of the parameter.
  HarmonicsControl(const Response &response, ErrorWatch &errors, double tolerance, double unit, Change change);

  /// More harmonics, if the error at `s` asks for them; or back to what they were, if the last ones were added in vain.
  bool refine(CurvePoint &s);
  /// After a step to `here`: fewer, where they would do.
  void spare(CurvePoint &here);
  /// Recovery has added some at that value of the parameter.
  void lent(double parameter) { lent_at_ = parameter, unchanged_ = 0; }

  void archive(Archive &archive);

private:
  bool may_spare(const CurvePoint &here);
  bool fewer_are_as_good(double error, CurvePoint &s);
  bool change(int harmonics, double error);
  int least() const; // harmonics

  const Response &response_;
  ErrorWatch &errors_;
  const double tolerance_, unit_;
  Change change_;
  int unchanged_ = 0; // points since harmonics were changed
  struct Before {
    int harmonics = 0;
    double error = 0;
  } raised_, coarse_;  // before harmonics were added for the step at hand; and where more did not help
  double lent_at_ = 0; // value of the parameter where more harmonics were taken last
};

} // namespace dovetail
