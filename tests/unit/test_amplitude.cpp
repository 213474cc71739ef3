// Half the peak-to-peak of trigonometric polynomials, and of what is watched along a curve.
#include <gtest/gtest.h>

#include <cmath>

#include "problems/amplitude.hpp"
#include "results/point_record.hpp"
#include "small_system.hpp"

namespace dovetail::testing {
namespace {

double value(const std::vector<double> &c, double theta) {
  double sum = 0;
  for (int k = 1; 2 * k < static_cast<int>(c.size()); ++k)
    sum += c[cosine(k)] * std::cos(k * theta) + c[sine(k)] * std::sin(k * theta);
  return sum;
}

TEST(Amplitude, ClosedForms) {
  EXPECT_NEAR(Swing(3).amplitude(std::vector<double>{5, 1, 0, 0, 0, -1.0 / 9, 0}.data()), 8.0 / 9, 1e-14);
  EXPECT_NEAR(Swing(2).amplitude(std::vector<double>{-7, 1, 0, 1, 0}.data()), 25.0 / 16, 1e-14); // from -9/8 to 2
}

TEST(Amplitude, IsHalfThePeakToPeakOfDenseSamples) {
  for (int trial = 0; trial < 200; ++trial) {
    const int H = 1 + trial % 9, samples = 20000;
    std::vector<double> c;
    for (int i = 0; i < 2 * H + 1; ++i) c.push_back(wave(trial, i));
    double high = -HUGE_VAL, low = HUGE_VAL, bend = 0;
    for (int j = 0; j < samples; ++j) {
      const double q = value(c, 2 * M_PI * j / samples);
      high = std::max(high, q), low = std::min(low, q);
    }
    for (int i = 1; i < 2 * H + 1; ++i) bend += std::abs(c[i]) * H * H;
    const double found = Swing(H).amplitude(c.data()), missed = bend * std::pow(M_PI / samples, 2) / 2;
    EXPECT_GE(found, (high - low) / 2 * (1 - 1e-13)) << "trial " << trial;
    EXPECT_LE(found, (high - low) / 2 + missed + 1e-13) << "trial " << trial;
  }
}

// The slope is the derivative along the curve, of a dof, of a sum of dofs, and of what moves most.
TEST(Amplitude, SlopesAgreeWithDifferences) {
  const HarmonicSystem system = small_system(LinearForm::modal);
  const Layout &layout = system.layout();
  std::vector<double> row;
  for (PetscInt i = 0; i < layout.dofs(); ++i) row.push_back(wave(11, static_cast<int>(i)));
  UniqueVec y = vector_of(system, 1, 3, 1.3), t = vector_of(system, 1, 5, 0.7), moved = system.unknowns();
  for (const Watched &watched : {Watched{}, Watched{layout.modes, {}}, Watched{-1, row}}) {
    AmplitudeMeter meter(layout, watched);
    const double h = 1e-5;
    const Amplitude here = meter(y, t);
    check(VecWAXPY(moved, h, t, y), "");
    const double ahead = meter(moved, t).value;
    check(VecWAXPY(moved, -h, t, y), "");
    const double behind = meter(moved, t).value;
    EXPECT_GT(here.value, 0);
    EXPECT_NEAR(here.slope, (ahead - behind) / (2 * h), 1e-7 * std::max(1.0, std::abs(here.slope)));
  }
}

TEST(Amplitude, OfASumOfOneDofIsThatOfTheDof) {
  const HarmonicSystem system = small_system(LinearForm::modal);
  const Layout &layout = system.layout();
  const UniqueVec y = vector_of(system, 1, 3, 1.3), t = vector_of(system, 1, 5, 0.7);
  for (PetscInt dof = 0; dof < layout.dofs(); ++dof) {
    std::vector<double> row(layout.dofs(), 0.0);
    row[dof] = -2;
    const Amplitude one = AmplitudeMeter(layout, {dof, {}})(y, t), sum = AmplitudeMeter(layout, {-1, row})(y, t);
    EXPECT_NEAR(sum.value, 2 * one.value, 1e-13 * one.value);
    EXPECT_NEAR(sum.slope, 2 * one.slope, 1e-10 * std::abs(one.slope) + 1e-12);
  }
}

TEST(CurveEnds, SayWhereTheAmplitudeStillRises) {
  CurveEnds up, down, jumped, continued(false);
  for (const double a : {1.0, 2.0, 3.0}) up.add({a, a, 0}), down.add({a, -a, 0}), continued.add({a, -a, 0});
  ASSERT_TRUE(up.rising() && down.falling());
  EXPECT_EQ(up.rising()->value, 3);
  EXPECT_EQ(down.falling()->value, 1);
  EXPECT_TRUE(!up.falling() && !down.rising() && !continued.falling());
  jumped.add({1, 1, 0}), jumped.add({2, 2, 0}), jumped.jump(), jumped.add({3, 3, 0});
  EXPECT_FALSE(jumped.rising()); // across a jump nothing rises
}

} // namespace
} // namespace dovetail::testing
