// Peaks over a parameter: derivatives of all equations against differences, and how fast Newton's method goes.
#include <gtest/gtest.h>

#include "continuation/curve.hpp"
#include "problems/peak_track.hpp"
#include "small_system.hpp"

using namespace dovetail;
using namespace dovetail::testing;

namespace {

constexpr double omega = 1.3;
const Watched watched{0, {}}; // the first mode

std::vector<double> sizes() { return alone() ? std::vector<double>{0.06, 0.6} : std::vector<double>{0.6}; }

struct Scene {
  explicit Scene(double load = 1, LinearForm form = LinearForm::assembled) {
    PreloadedModel model = small_preloaded(PETSC_COMM_WORLD);
    preload = std::make_shared<VariedPreload>(model);
    system.emplace(scaled(std::move(model), 0.05, {}), 3, exactly, course({0.2, load, 0.3 * load}), form);
    peak.emplace(*system, watched);
  }
  PeakTrack track(const PathParameter &parameter, TrackCondition &condition) {
    return PeakTrack(*peak, parameter, preload, condition, 0.1);
  }

  std::shared_ptr<VariedPreload> preload;
  std::optional<HarmonicSystem> system;
  std::optional<PeakEquations> peak;
};

UniqueVec point_of(Scene &scene, PeakTrack &track, double size, int seed, double at_omega, double p) {
  UniqueVec y = track.unknowns();
  scene.peak->take(vector_of(*scene.system, size, seed, at_omega));
  track.give(p, y);
  return y;
}

// Of the condition's row alone, which a motion of many unknowns would hide, and of all rows.
std::pair<double, double> errors(PeakTrack &track, Vec y, Vec v, double h) {
  UniqueVec f = track.unknowns(), slope = track.unknowns(), at = track.unknowns(), product = track.unknowns();
  for (const double side : {1.0, -1.0}) {
    check(VecWAXPY(at, side * h, v, y), "");
    check(VecSet(f, 0), "");
    track.residual(at, f);
    check(VecAXPY(slope, side / (2 * h), f), "");
  }
  const auto jacobian = track.jacobian();
  jacobian->assemble(y, track.unknowns());
  check(MatMult(jacobian->matrix(), v, product), "");
  const double row = track.omega_of(product); // the place of Omega is that of the condition
  return {std::abs(track.omega_of(slope) - row) / std::abs(row), relative_difference(slope, product)};
}

// At the highest motion of a coarse sweep.
bool find_peak(PeakEquations &peak, Scene &scene) {
  double best = 0, at = 0;
  for (double w = 0.6; w < 1.6; w += 0.02) {
    peak.take(vector_of(*scene.system, 0, 1, w));
    if (!peak.solve() || !peak.differentiate() || peak.amplitude() <= best) continue;
    best = peak.amplitude(), at = w;
  }
  peak.take(vector_of(*scene.system, 0, 1, at));
  return at > 0 && peak.solve() && peak.climb();
}

} // namespace

TEST(PeakTrack, derivatives_by_motion_frequency_and_parameter) {
  for (const bool phase : {false, true})
    for (const PathParameter &parameter : all_parameters) {
      if (&parameter == &frequency_parameter()) continue;
      Scene scene;
      std::unique_ptr<TrackCondition> condition;
      if (phase)
        condition = std::make_unique<PhaseResonance>(*scene.peak);
      else
        condition = std::make_unique<Extremum>(*scene.peak);
      PeakTrack track = scene.track(parameter, *condition);
      for (const double size : sizes()) {
        const double p = parameter.positive() ? 1.1 : 0.02;
        const UniqueVec y = point_of(scene, track, size, 3, omega, p), v = point_of(scene, track, size, 5, 0.4, 0.3);
        const auto [row, all] = errors(track, y, v, 1e-5);
        EXPECT_LT(row, 2e-5) << parameter.name << ", motion " << size << ", phase " << phase;
        EXPECT_LT(all, 2e-5) << parameter.name << ", motion " << size << ", phase " << phase;
      }
    }
}

TEST(PeakTrack, derivatives_of_a_graze) {
  for (const PathParameter &parameter : all_parameters) {
    if (&parameter == &frequency_parameter()) continue;
    Scene scene;
    int found = 0;
    for (const double size : alone() ? std::vector<double>{0.06, 0.2, 0.6} : sizes()) {
      const UniqueVec motion = vector_of(*scene.system, size, 3, omega);
      scene.system->vary(ResponseParameter().beside(parameter, parameter.positive() ? 1.1 : 0.02), scene.preload);
      const auto grazes = scene.system->grazes(motion);
      for (int own = 0; own < (alone() ? 9 : 4); ++own) { // of the first point that any rank has them of
        int rank = scene.system->layout().rank, most = 0;
        const bool has = !grazes.empty() && static_cast<int>(grazes[0].size()) > own;
        int winner = has ? rank : -1;
        MPI_Allreduce(MPI_IN_PLACE, &winner, 1, MPI_INT, MPI_MAX, PETSC_COMM_WORLD);
        if (winner < 0) break;
        most = winner == rank;
        Grazing condition(*scene.peak, most ? 0 : -1, most ? grazes[0][own] : Graze{});
        PeakTrack track = scene.track(parameter, condition);
        const UniqueVec y = point_of(scene, track, size, 3, omega, parameter.positive() ? 1.1 : 0.02),
                        v = point_of(scene, track, size, 5, 0.4, 0.3);
        EXPECT_LT(errors(track, y, v, 1e-6).first, 1e-5) << parameter.name << ", motion " << size << ", graze " << own;
        ++found;
      }
    }
    EXPECT_GT(found, 3) << parameter.name;
  }
}

TEST(PeakTrack, derivatives_do_not_depend_on_the_point_before) {
  for (const LinearForm form : {LinearForm::assembled, LinearForm::modal}) {
    Scene scene(1, form);
    PeakEquations &peak = *scene.peak;
    const auto differentiate = [&](double size, double at_omega, double accuracy) {
      peak.take(vector_of(*scene.system, size, 3, at_omega));
      EXPECT_TRUE(peak.differentiate(accuracy));
      UniqueVec along = scene.system->unknowns();
      check(VecCopy(peak.along(), along), "");
      return std::pair{peak.c(), std::move(along)};
    };
    std::vector<std::pair<double, double>> places{{0.6001, omega}};
    if (alone()) places.insert(places.end(), {{0.6, omega}, {0.06, 1.1 * omega}});
    for (const auto &[size, at_omega] : places) {
      differentiate(0.6, omega, 1e-6);
      const auto [c, along] = differentiate(size, at_omega, 1e-6);
      peak.begin_solves(peak.solver_memory());
      const auto [alone_c, alone_along] = differentiate(size, at_omega, PeakEquations::finest);
      EXPECT_NEAR(c, alone_c, 1e-8 * std::abs(alone_c)) << "size " << size;
      EXPECT_LT(relative_difference(along, alone_along), 1e-5) << "size " << size;
    }
  }
}

TEST(PeakTrack, newton_converges_quadratically) {
  for (const char *name : alone() ? std::vector{"force", "friction", "gap"} : std::vector{"friction"}) {
    const PathParameter &parameter = *parameter_named(name);
    Scene scene(0.3);
    ASSERT_TRUE(find_peak(*scene.peak, scene)) << name;
    Extremum condition(*scene.peak);
    PeakTrack track = scene.track(parameter, condition);
    SolveCounts counts;
    Curve curve(track, {1e-10, 1e-10, 20}, 1, true, counts);
    CurvePoint s = curve.point();
    const double p = parameter.positive() ? 1 : 0;
    track.give(p, s.y);
    ASSERT_TRUE(curve.solve_at(p, s)) << name << ": " << s.newton.why;
    EXPECT_LE(s.newton.newton, 2) << name; // climb() has been there
    ASSERT_TRUE(curve.solve_at(p + 2e-3, s)) << name << ": " << s.newton.why;
    EXPECT_LE(s.newton.newton, 5) << name;
    track.take(s.y);
    ASSERT_TRUE(scene.peak->differentiate());
    scene.peak->turn();
    EXPECT_GT(scene.peak->slope(), 0) << name; // a maximum
  }
}
