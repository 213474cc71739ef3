#pragma once
// The commands that follow no curve. Collective.
#include "app/preparation.hpp"

namespace dovetail {

/// Everything in force and the forecast sizes, after reading the model once for its checks and analysing its K_ee.
void show(MPI_Comm comm, const Checked &checked, const Voice &voice);

/// `dovetail check`: what a dry run refuses, and what is doubtful. As there a reduced model is used if it is at hand.
void check_case(MPI_Comm comm, const Checked &checked, const Voice &voice);

/// `dovetail modes`: of earlier runs in the folder it replaces nothing but a reduced file that no longer fits.
void show_modes(MPI_Comm comm, const Checked &checked, const Voice &voice);

} // namespace dovetail
