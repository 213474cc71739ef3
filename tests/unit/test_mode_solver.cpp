// Modes by every kind of eigensolver of SLEPc that finds them, by -modes_eps_type; on any number of ranks.
#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <regex>
#include <tuple>

#include "lattice_model.hpp"
#include "reduction/clamped_structure.hpp"
#include "reduction/elastic_modes.hpp"
#include "small_system.hpp"
#include "support/error.hpp"
#include "temporary_file.hpp"

namespace dovetail {
namespace {

using testing::Option;
using testing::said;

constexpr int wanted = 12;

ClampedStructure lattice() {
  ClampedStructure parts = clamp(testing::lattice_model(PETSC_COMM_WORLD, 9, 4, 5));
  parts.solver->factor();
  return parts;
}

ElasticModes modes_of(const ClampedStructure &parts, PetscInt count = wanted) {
  return elastic_modes(*parts.solver, parts.K.ee, parts.M.ee, parts.elastic_dofs, count, "lattice");
}

double largest_difference(MPI_Comm comm, const Tall &a, const Tall &b) {
  double most[2] = {0, 0};
  for (std::size_t i = 0; i < a.values.size(); ++i) {
    most[0] = std::max(most[0], std::abs(a.values[i] - b.values[i]));
    most[1] = std::max(most[1], std::abs(a.values[i]));
  }
  MPI_Allreduce(MPI_IN_PLACE, most, 2, MPI_DOUBLE, MPI_MAX, comm);
  return most[0] / most[1];
}

struct Kind {
  const char *type;
  double squares, shapes;           // relative errors
  std::vector<const char *> more{}; // options it needs, and their values
  bool same_bits = true;            // when asked again
  int count = wanted;               // of modes
};

void PrintTo(const Kind &kind, std::ostream *out) { *out << kind.type; }

// The options of a kind while it lives.
struct Chosen {
  std::vector<std::unique_ptr<Option>> options;

  explicit Chosen(const Kind &kind) {
    options.push_back(std::make_unique<Option>("-modes_eps_type", kind.type));
    for (std::size_t i = 0; i < kind.more.size(); i += 2)
      options.push_back(std::make_unique<Option>(kind.more[i], kind.more[i + 1]));
  }
};

class EveryType : public ::testing::TestWithParam<Kind> {};

TEST_P(EveryType, FindsTheSameModesAndAgainTheSameBits) {
  const ClampedStructure parts = lattice();
  const int count = GetParam().count;
  const ElasticModes ours = modes_of(parts, count);
  const Chosen options(GetParam());
  const ElasticModes found = modes_of(parts, count);
  ASSERT_EQ(found.squares.size(), ours.squares.size());
  for (int j = 0; j < count; ++j) EXPECT_NEAR(found.squares[j] / ours.squares[j], 1, GetParam().squares);
  EXPECT_LT(largest_difference(PETSC_COMM_WORLD, ours.shapes, found.shapes), GetParam().shapes);
  const auto G = gram(PETSC_COMM_WORLD, found.shapes, 0, count, multiply(parts.M.ee, found.shapes), 0, count);
  for (int i = 0; i < count; ++i)
    for (int j = 0; j < count; ++j) EXPECT_NEAR(G[j * count + i], i == j, GetParam().shapes);
  if (!GetParam().same_bits) return;
  const ElasticModes again = modes_of(parts, count);
  EXPECT_EQ(found.squares, again.squares);
  EXPECT_EQ(found.shapes.values, again.shapes.values);
}

// The last two add messages of several ranks as these come, and no page promises them the same bits. Twelve modes of
// lobpcg, jd or rqcg take longer than all the rest.
const Kind kinds[] = {
    {"blocklanczos", 1e-14, 1e-14},
    {"krylovschur", 1e-12, 1e-10},
    {"arnoldi", 1e-12, 1e-10},
    {"subspace", 1e-12, 1e-10},
    {"lobpcg", 1e-12, 1e-8, {}, true, 4},
    {"gd", 1e-12, 1e-8},
    {"jd", 1e-12, 1e-8, {}, true, 4},
    {"rqcg", 1e-12, 1e-8, {"-modes_eps_max_it", "5000"}, true, 2},
    {"scalapack", 1e-10, 1e-8, {}, false},
    {"ciss", 1e-12, 1e-8, {"-modes_rg_type", "interval", "-modes_rg_interval_endpoints", "0,3e5,0,0"}, false}};

const auto name_of = [](const auto &found) { return std::string(found.param.type); };
INSTANTIATE_TEST_SUITE_P(ModeSolver, EveryType, ::testing::ValuesIn(kinds), name_of);

void expect_words(const std::string &text, const std::vector<const char *> &words) {
  for (const char *word : words) EXPECT_NE(text.find(word), std::string::npos) << word << " in: " << text;
}

// Those that iterate are judged by backward errors, which have no unit: of powers of two they do the same to the bit.
TEST(ModeSolver, TheUnitOfMassDoesNotMatter) {
  const Option kind("-modes_eps_type", "lobpcg");
  const ClampedStructure parts = lattice();
  const std::vector<double> plain = modes_of(parts, 3).squares;
  for (const double unit : {0x1p40, 0x1p-40}) {
    const ClampedStructure other = lattice();
    check(MatScale(other.M.ee, unit), "test");
    const std::vector<double> found = modes_of(other, 3).squares;
    for (int j = 0; j < 3; ++j) EXPECT_NEAR(found[j] * unit / plain[j], 1, 1e-12) << unit;
  }
}

TEST(ModeSolver, TellsHowManyHaveConverged) {
  const ClampedStructure parts = lattice();
  for (const char *type : {"blocklanczos", "krylovschur", "lobpcg"}) {
    const Option kind("-modes_eps_type", type), most("-modes_eps_max_it", "2"), strict("-modes_eps_tol", "1e-15");
    expect_words(said<ComputeError>([&] { modes_of(parts, 60); }),
                 {"of 60 fixed-interface modes converged", type, "-modes_eps_max_it", "reduction.modes"});
  }
}

TEST(ModeSolver, TellsUpToWhichFrequencyTheyHaveConverged) {
  const ClampedStructure parts = lattice();
  const std::vector<double> squares = modes_of(parts, 60).squares;
  int some = 0;
  for (const auto &[type, tolerance] : {std::pair{"lobpcg", "1e-15"}, {"krylovschur", "1e-4"}}) { // none and some
    const Option kind("-modes_eps_type", type), most("-modes_eps_max_it", "1"), loose("-modes_eps_tol", tolerance);
    const std::string text = said<ComputeError>([&] { modes_of(parts, 60); });
    std::smatch found;
    ASSERT_TRUE(
        std::regex_match(text, found,
                         std::regex("while computing modes: (\\d+) of 60 fixed-interface modes converged(, those up to "
                                    "(.*) Hz)? \\(SLEPc's " +
                                    std::string(type) +
                                    ", DIVERGED_ITS after 1 of at most 1 iterations\\). "
                                    "Raise -modes_eps_max_it, or -modes_eps_ncv above (\\d+); take another "
                                    "-modes_eps_type; or ask for fewer in reduction.modes")))
        << text;
    const int count = std::stoi(found[1]);
    EXPECT_EQ(found[2].matched, count > 0);
    EXPECT_GE(std::stoi(found[4]), 60);
    if (count == 0) continue;
    ++some;
    EXPECT_NEAR(std::stod(found[3]) / (std::sqrt(squares[count - 1]) / (2 * M_PI)), 1, 1e-4);
  }
  EXPECT_EQ(some, 1);
}

TEST(ModeSolver, TellsThatTheRegionIsTooSmall) {
  const ClampedStructure parts = lattice();
  const Chosen options({"ciss", 0, 0, {"-modes_rg_type", "interval", "-modes_rg_interval_endpoints", "0,1e5,0,0"}});
  expect_words(said<ComputeError>([&] { modes_of(parts); }),
               {"while computing modes: only 5 of 12 modes lie in the region that -modes_rg_interval_endpoints gives "
                "[rad^2/s^2], as far as SLEPc's ciss has converged (",
                "). Make it wider, or raise "
                "-modes_eps_max_it above "});
}

TEST(ModeSolver, RefusesOptionsThatContradictWhatIsSought) {
  const ClampedStructure parts = lattice();
  const std::string end =
      "; the modes sought are the lowest of K_ee v = w^2 M_ee v, as many as reduction.modes says, with "
      "the factors of K_ee";
  const std::tuple<const char *, const char *, const char *> wrong[] = {
      {"-modes_eps_target", "3", "(eps_target, st_shift) shift K_ee"},
      {"-modes_st_shift", "3", "(eps_target, st_shift) shift K_ee"},
      {"-modes_eps_nev", "3", "eps_nev ask for 3 eigenvalues instead of 12"},
      {"-modes_eps_smallest_real", "", "(eps_smallest_real and the like) ask for another part of the spectrum"},
      {"-modes_st_type", "cayley", "(st_type) take another transformation than sinvert"},
      {"-modes_eps_gen_non_hermitian", "", "(eps_hermitian and the like) ask for another kind of problem"}};
  for (const auto &[name, value, words] : wrong) {
    const Option option(name, value);
    EXPECT_EQ(said<InputError>([&] { modes_of(parts); }), std::string("the options -modes_ ") + words + end);
  }
  const Option option("-modes_eps_type", "fastest");
  EXPECT_TRUE(std::regex_match(said<InputError>([&] { modes_of(parts); }),
                               std::regex("-modes_eps_type fastest is no eigensolver of SLEPc; it has \\w+(, \\w+)*, "
                                          "krylovschur(, \\w+)*, blocklanczos")));
}

TEST(ModeSolver, TooFewColumnsAreRefused) {
  const ClampedStructure parts = lattice();
  const Option option("-modes_eps_ncv", "13");
  expect_words(said<ComputeError>([&] { modes_of(parts); }), {"-eps_ncv 28 at least", "13"});
}

// Masses on a chain of springs that is held at both ends.
struct Chain {
  Range own = own_share(PETSC_COMM_WORLD, 60);
  UniqueMat K, M;
  std::vector<long> names;

  explicit Chain(const std::function<double(PetscInt)> &mass) {
    for (UniqueMat *A : {&K, &M}) {
      check(MatCreateAIJ(PETSC_COMM_WORLD, own.size(), own.size(), 60, 60, 3, nullptr, 3, nullptr, A->out()), "test");
      for (PetscInt i = own.begin; i < own.end; ++i) {
        check(MatSetValue(*A, i, i, A == &K ? 2 : mass(i), INSERT_VALUES), "test");
        if (A == &K && i > 0) check(MatSetValue(*A, i, i - 1, -1, INSERT_VALUES), "test");
        if (A == &K && i < 59) check(MatSetValue(*A, i, i + 1, -1, INSERT_VALUES), "test");
      }
      check(MatAssemblyBegin(*A, MAT_FINAL_ASSEMBLY), "test");
      check(MatAssemblyEnd(*A, MAT_FINAL_ASSEMBLY), "test");
      check(MatSetOption(*A, MAT_SYMMETRIC, PETSC_TRUE), "test");
    }
    for (PetscInt i = own.begin; i < own.end; ++i) names.push_back(i);
  }

  ElasticModes modes(PetscInt count) const {
    ClampedSolver solver(K, "chain");
    solver.factor();
    return elastic_modes(solver, K, M, names, count, "chain");
  }
};

TEST(ModeSolver, MasslessDofsHaveNoModes) {
  const Chain chain([](PetscInt i) { return i % 6 == 0 ? 1.0 : 0.0; }); // ten masses
  EXPECT_EQ(chain.modes(10).squares.size(), 10u);
  expect_words(said<InputError>([&] { chain.modes(11); }),
               {"chain: only 10 of the 11 modes of reduction.modes have mass"});
}

TEST(ModeSolver, NegativeMassIsRefused) {
  const Chain chain([](PetscInt i) { return i == 30 ? -1.0 : 1.0; });
  for (const char *type : {"blocklanczos", "krylovschur"}) {
    const Option kind("-modes_eps_type", type);
    expect_words(said<InputError>([&] { chain.modes(5); }), {"chain: /M is not positive definite on the elastic dofs"});
  }
}

} // namespace
} // namespace dovetail
