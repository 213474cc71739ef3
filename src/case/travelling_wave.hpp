#pragma once
// A load that travels round N equal sectors, and with it the spatial index of each harmonic (nodal diameter, signed).
namespace dovetail {

struct TravellingWave {
  int sectors = 0;      ///< N; 0: no cyclic symmetry
  int engine_order = 0; ///< EO

  /// h_k = k EO mod N, in -N/2 < h <= N/2.
  int index(int harmonic) const {
    if (sectors == 0) return 0;
    const long product = static_cast<long>(harmonic) * (engine_order % sectors);
    const int h = static_cast<int>((product % sectors + sectors) % sectors);
    return h > sectors / 2 ? h - sectors : h;
  }
};

} // namespace dovetail
