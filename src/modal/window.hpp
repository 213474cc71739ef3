#pragma once
// A contact that is open for most of the period sees little of a motion: while it is closed, all 2H+1 waves of which
// the motion consists are combinations of few of them, about as many as the window is long in waves and some more for
// each of its ends (Slepian 1978). Its force, and the derivative of its force, are those that such few waves make.
#include <cstddef>
#include <vector>

#include "contact/linearisation.hpp"

namespace dovetail {

struct Window {
  std::vector<int> waves;      ///< (r) the few, by the numbers of their coefficients
  std::vector<double> weights; ///< (r, 2H+1) every wave of them; that of the mean counts by 1 / sqrt 2
};

/// What is left of any wave while the mask is 1 is less than 1e-5 of it. No waves: there are more than `most`.
Window window_of(const MaskMeans &closed, std::size_t most);
/// All of them.
Window whole_window(int harmonics);

} // namespace dovetail
