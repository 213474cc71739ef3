#pragma once
// What the program asks of a contact law, in place of its name.
#include "contact/contact_point.hpp"

namespace dovetail {

/// The normal spring only pushes.
constexpr bool may_open(Law law) { return law != Law::bilateral; }
/// Both tangential directions share one slider, with one coefficient of friction; its forces are sampled.
constexpr bool shares_slider(Law law) { return law == Law::cone; }

} // namespace dovetail
