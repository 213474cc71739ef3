// How arc length is measured, against sums by hand, on shares of ranks that are uneven; and what is kept with vectors.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <set>

#include "continuation/problem.hpp"
#include "support/error.hpp"

using namespace dovetail;

namespace {

constexpr int least = 2; // unknowns of a rank, with the parameter on the last

// Vectors over all ranks; nothing is solved.
struct Spread : Problem {
  Spread() {
    int size;
    MPI_Comm_rank(PETSC_COMM_WORLD, &rank), MPI_Comm_size(PETSC_COMM_WORLD, &size);
    for (int r = 0; r < size; ++r) all += least + r;
    last = rank == size - 1;
  }
  const Parameter &parameter() const override { return name; }
  UniqueVec unknowns() const override {
    UniqueVec y;
    check(VecCreateMPI(PETSC_COMM_WORLD, least + rank, all, y.out()), "");
    check(VecSet(y, 0), "");
    return y;
  }
  void residual(Vec y, Vec f) override { check(VecAXPBY(f, 2, 0, y), ""); }
  std::unique_ptr<BorderedJacobian> jacobian() override { return nullptr; }
  UniqueVec filled(const std::function<double(int)> &entry) const {
    UniqueVec y = unknowns();
    PetscInt first, end;
    check(VecGetOwnershipRange(y, &first, &end), "");
    for (PetscInt i = first; i < end; ++i) check(VecSetValue(y, i, entry(static_cast<int>(i)), INSERT_VALUES), "");
    check(VecAssemblyBegin(y), ""), check(VecAssemblyEnd(y), "");
    return y;
  }
  double sum(const std::function<double(int)> &term) const { // over all but the parameter
    double total = 0;
    for (int i = 0; i + 1 < all; ++i) total += term(i);
    return total;
  }

  Parameter name{"p", "-"};
  int rank = 0, all = 0;
  bool last = false;
};

double rising(int i) { return 1 + 0.5 * i; }
double waving(int i) { return std::cos(i); }

} // namespace

TEST(PlainMetric, products_are_of_motions_by_the_largest_and_of_parameters_by_their_unit) {
  const Spread spread;
  const int p = spread.all - 1;
  const UniqueVec a = spread.filled(rising), b = spread.filled(waving), row = spread.unknowns();
  const double of_a = spread.sum([](int i) { return rising(i) * rising(i); }),
               of_b = spread.sum([](int i) { return waving(i) * waving(i); }),
               of_both = spread.sum([](int i) { return rising(i) * waving(i); }), both = rising(p) * waving(p);
  for (const bool weighted : {true, false})
    for (const bool seen : {true, false}) {
      const auto norm = spread.metric(0.5, weighted);
      EXPECT_EQ(norm->largest_motion(), 0);
      if (seen) norm->see(b), norm->see(a), norm->see(b); // the largest counts
      EXPECT_NEAR(norm->largest_motion(), seen ? std::sqrt(of_a) : 0, 1e-12);
      const double motion = weighted && seen ? 1 / of_a : 1, parameter = weighted ? 4 : 1;
      const auto found = norm->products({{a, b}, {b, b}}, {b, a}, {a, b});
      ASSERT_EQ(found.size(), 6u);
      EXPECT_NEAR(found[0], motion * of_both + parameter * both, 1e-12);
      EXPECT_NEAR(found[1], motion * of_b + parameter * waving(p) * waving(p), 1e-12);
      EXPECT_NEAR(found[2], of_b, 1e-12);
      EXPECT_NEAR(found[3], of_a, 1e-11);
      EXPECT_EQ(found[4], rising(p));
      EXPECT_EQ(found[5], waving(p));
      EXPECT_EQ(parameter_of(a), rising(p));
      EXPECT_EQ(parameter_of(b), waving(p));
      EXPECT_NEAR(norm->product(a, b), found[0], 1e-12);
      EXPECT_NEAR(norm->length(b), std::sqrt(found[1]), 1e-12);
      norm->weigh(a, row);
      double along;
      check(VecDot(row, b, &along), "");
      EXPECT_NEAR(along, found[0], 1e-12);
      EXPECT_NEAR(parameter_of(row), parameter * rising(p), 1e-12);
    }
}

TEST(PlainMetric, small_motions_are_measured_by_the_largest_too) {
  const Spread spread;
  const auto norm = spread.metric(1, true);
  const UniqueVec a = spread.filled(rising);
  set_parameter(a, 0);
  const double length = norm->length(a);
  check(VecScale(a, 0.25 / length), "");
  norm->see(a);
  EXPECT_NEAR(norm->largest_motion(), 0.25, 1e-15);
  EXPECT_NEAR(norm->length(a), 1, 1e-14);
}

TEST(PlainMetric, a_plane_is_a_product_beside_the_residual) {
  Spread spread;
  const UniqueVec a = spread.filled(rising), b = spread.filled(waving), f = spread.unknowns();
  const int p = spread.all - 1;
  EXPECT_NEAR(spread.residual_and_plane(a, f, b),
              spread.sum([](int i) { return rising(i) * waving(i); }) + rising(p) * waving(p), 1e-12);
  EXPECT_NEAR(parameter_of(f), 2 * rising(p), 1e-12);
}

TEST(KeptNumbers, of_a_vector_stay_until_it_changes) {
  const Spread spread;
  const int p = spread.all - 1;
  const UniqueVec y = spread.filled(waving);
  EXPECT_EQ(parameter_of(y), waving(p));
  note_parameter(y, 7); // not so, but told
  EXPECT_EQ(parameter_of(y), 7);
  set_parameter(y, 5);
  EXPECT_EQ(parameter_of(y), 5);
  const double length = std::sqrt(spread.sum([](int i) { return waving(i) * waving(i); }) + 25);
  EXPECT_NEAR(plain_length(y), length, 1e-12);
  note_plain_length(y, 3);
  EXPECT_EQ(plain_length(y), 3);
  scale_known(y, -2);
  EXPECT_EQ(parameter_of(y), -10);
  EXPECT_EQ(plain_length(y), 6);
  forget_plain_length(y);
  EXPECT_NEAR(plain_length(y), 2 * length, 1e-12);
  check(VecScale(y, 3), "");
  EXPECT_EQ(parameter_of(y), -30);
  scale_known(y, 0.5); // its length is not known, and is measured then
  EXPECT_NEAR(plain_length(y), 3 * length, 1e-12);
  EXPECT_EQ(parameter_of(y), -15);
  note_parameter(y, 8), note_plain_length(y, 9);
  EXPECT_EQ(parameter_of(y), 8); // neither is taken for the other
  EXPECT_EQ(plain_length(y), 9);
}

// Restarts compare projections with those that an older run has kept: the numbers are for ever. Computed by Python.
TEST(PseudoRandom, numbers_are_those_of_the_formula) {
  EXPECT_DOUBLE_EQ(pseudo_random(0, 0, 0), 0.7666216164272852);
  EXPECT_DOUBLE_EQ(pseudo_random(3, 2, 1), -0.0372236149142795);
  EXPECT_DOUBLE_EQ(pseudo_random(100, 0, 5), 0.4481495174522936);
}

TEST(PseudoRandom, numbers_lie_on_both_sides_of_zero) {
  std::set<double> met;
  double sum = 0, square = 0;
  for (int a = 0; a < 20; ++a)
    for (int b = 0; b < 20; ++b)
      for (int which = 0; which < 6; ++which) {
        const double value = pseudo_random(a, b, which);
        EXPECT_LT(std::abs(value), 1);
        met.insert(value), sum += value, square += value * value;
      }
  EXPECT_EQ(met.size(), 2400u);
  EXPECT_NEAR(sum / 2400, 0, 0.05);
  EXPECT_NEAR(square / 2400, 1.0 / 3, 0.03);
}

TEST(SpreadProjections, are_sums_over_all_ranks_by_the_numbers_of_unknowns) {
  const Spread spread;
  const UniqueVec a = spread.filled(rising), b = spread.filled(waving);
  const auto found = spread.projected({a, b}), own = spread.own_projected({b});
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0][0], rising(spread.all - 1));
  EXPECT_EQ(found[1][0], waving(spread.all - 1));
  EXPECT_EQ(own[0][0], spread.last ? waving(spread.all - 1) : 0);
  for (int k = 1; k < Problem::projections; ++k) {
    EXPECT_NEAR(found[0][k], spread.sum([k](int i) { return pseudo_random(i, 0, k) * rising(i); }), 1e-12);
    EXPECT_NEAR(found[1][k], spread.sum([k](int i) { return pseudo_random(i, 0, k) * waving(i); }), 1e-12);
  }
}
