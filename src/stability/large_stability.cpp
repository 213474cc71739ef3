#include "stability/large_stability.hpp"

#include "stability/growth.hpp"
#include "stability/wave_system.hpp"

namespace dovetail {
namespace {

constexpr double accuracy = 1e-7; // of the exponents over Omega

DenseModel own_points(const HarmonicSystem &system) {
  DenseModel out;
  out.contact = system.contact(), out.standstill = system.standstill();
  out.points = static_cast<int>(out.contact.size());
  return out;
}

Growth by_hill(const HarmonicSystem &system, Waves waves, double omega, const ContactReading &from,
               double strip = 0.25) {
  const std::vector<double> blocks = from.answers(waves, system.harmonics(), exponent_shift);
  const auto exponents = WaveSystem(system, waves, omega, blocks, from.history().holds).near_zero(strip);
  return exponents.found ? largest_of(exponents.values, waves) : Growth{};
}

} // namespace

LargeStabilityTest::LargeStabilityTest(const HarmonicSystem &system)
    : system_(system), own_(own_points(system)), reading_(own_, system.harmonics()) {
  if (!system.scaled().damping.acts_in_time()) throw ComputeError("stability: not with hysteretic damping");
}

Stability LargeStabilityTest::judge(Vec y) {
  const Layout &layout = system_.layout();
  own_.contact = system_.contact(), own_.standstill = system_.standstill();
  const double omega = system_.parameter().at(system_.parameter_in(y)).omega;
  const double *values;
  check(VecGetArrayRead(y, &values), "judging stability");
  reading_.read({values + layout.own_point_offset(0), values + layout.own_coefficients()});
  check(VecRestoreArrayRead(y, &values), "judging stability");
  int sampled = reading_.sampled(); // on any rank
  MPI_Allreduce(MPI_IN_PLACE, &sampled, 1, MPI_INT, MPI_MAX, layout.comm);
  if (sampled) return conclude_sampled(by_hill(system_, Waves::whole, omega, reading_, 0.5));
  return conclude_alone(
      larger(by_hill(system_, Waves::whole, omega, reading_), by_hill(system_, Waves::half, omega, reading_)),
      accuracy);
}

} // namespace dovetail
