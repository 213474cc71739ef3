// Harmonic balance of a cyclic sector: derivatives in every state of the contacts, formulas row by row, and an index
// that is the same for all harmonics. On any number of ranks.
#include <gtest/gtest.h>

#include <complex>

#include "harmonic/harmonic_system.hpp"
#include "problems/peak_sensitivity.hpp"
#include "problems/peak_track.hpp"
#include "small_sector.hpp"

using namespace dovetail;
using namespace dovetail::testing;

TEST(SectorAssembled, jacobian_of_every_law_and_engine_order) {
  for (const auto &[samples, laws] : {std::pair<int, std::vector<Law>>{exactly, {}},
                                      {64, {}},
                                      {exactly, {Law::cone, Law::bilateral, Law::unilateral}}})
    for (const int engine_order : {1, -1, 2, 3, 5, 6}) {
      HarmonicSystem system = sector_system(engine_order, samples, laws);
      for (const double size : {0.004, 0.06, 0.6}) { // from all stuck to all opening
        const UniqueVec y = vector_of(system, size, 3, 0.8);
        for (int seed = 100; seed < 103; ++seed)
          EXPECT_LT(directional_error(system, y, vector_of(system, 1, seed, 0.3)), 1e-8)
              << "samples " << samples << ", engine order " << engine_order << ", size " << size;
      }
    }
}

TEST(SectorAssembled, every_contact_state_occurs) { // else the test above shows less than it says
  HarmonicSystem system = sector_system(1);
  std::array<long, 3> seen{}; // stuck, slips, opens
  for (const double size : {0.004, 0.06, 0.6}) {
    UniqueVec f = system.unknowns();
    system.residual(vector_of(system, size, 3, 0.8), f);
    for (const Activity &did : system.activity()) ++seen[did.open > 0 ? 2 : did.slip > 0 ? 1 : 0];
  }
  MPI_Allreduce(MPI_IN_PLACE, seen.data(), 3, MPI_LONG, MPI_SUM, PETSC_COMM_WORLD);
  for (const long count : seen) EXPECT_GT(count, 0);
}

TEST(SectorAssembled, derivatives_with_all_damping_it_takes) {
  Damping damping(0.03, 0.02, 0.04);
  damping.contact = true;
  HarmonicSystem system = sector_system(1, exactly, {}, damping);
  ASSERT_NE(system.dampers(), nullptr);
  const UniqueVec y = vector_of(system, 0.3, 5, 1.3);
  EXPECT_LT(directional_error(system, y, vector_of(system, 1, 17, 0.4)), 1e-8);
  EXPECT_LT(directional_error(system, y, vector_of(system, 0, 0, 1)), 1e-9); // eq (13)
}

TEST(SectorAssembled, engine_order_0_is_the_plain_model) {
  for (const int engine_order : {0, sectors, -sectors}) {
    HarmonicSystem sector = sector_system(engine_order), plain = sector_system(0, exactly, {}, 0.05, {}, false);
    ASSERT_TRUE(sector.is_cyclic());
    ASSERT_FALSE(plain.is_cyclic());
    const UniqueVec y = vector_of(plain, 0.3, 5, 1.3), v = vector_of(plain, 1, 9, 0.4),
                    last = vector_of(plain, 1, 2, 1);
    UniqueVec f = plain.unknowns(), g = plain.unknowns();
    plain.residual(y, f), sector.residual(y, g);
    EXPECT_LT(relative_difference(g, f), 1e-14);
    const UniqueMat A = plain.matrix(), B = sector.matrix();
    plain.jacobian(y, last, A), sector.jacobian(y, last, B);
    check(MatMult(A, v, f), "");
    check(MatMult(B, v, g), "");
    EXPECT_LT(relative_difference(g, f), 1e-14);
  }
}

TEST(SectorAssembled, linear_part_is_that_of_the_index) { // row by row, in complex numbers, where no contact acts
  const double xi = 0.05, omega = 0.9;
  for (const int engine_order : {1, -1, 2}) {
    ReducedModel model = small_sector();
    PreloadedModel open{model, small_contact(model), std::vector<Standstill>(model.own_points.size())};
    for (ContactPoint &point : open.contact) point.gap = 1e6;
    ScaledModel made = scaled(std::move(open), xi, {});
    made.engine_order = engine_order;
    HarmonicSystem system(std::move(made), harmonics, 16, course(fourier));
    const Layout &layout = system.layout();
    const int n = layout.width;
    const UniqueVec y = vector_of(system, 1, 5, omega);
    UniqueVec f = system.unknowns();
    system.residual(y, f);
    const std::vector<double> q = all_coefficients(layout, y);
    const double *own;
    check(VecGetArrayRead(f, &own), "");
    for (int k = 1; k <= harmonics; ++k) {
      const int h = system.wave().index(k);
      const auto of_index = [&](Complex value) { return h < 0 ? std::conj(value) : value; };
      const auto amplitude = [&](const double *c) { return Complex(c[cosine(k)], -c[sine(k)]); };
      const auto motion = [&](PetscInt row) { return amplitude(&q[row * n]); };
      const std::size_t place = cosine(k);
      const Complex course(place < fourier.size() ? fourier[place] : 0,
                           place + 1 < fourier.size() ? -fourier[place + 1] : 0),
          damped(1, k * omega * xi);
      const double z2 = k * omega * k * omega;
      for (PetscInt i = 0; i < model.own_contact_dofs(); ++i) {
        Complex sum = 0;
        const auto add = [&](Complex K, Complex M, Complex z) { sum += (of_index(K) * damped - z2 * of_index(M)) * z; };
        const SectorIndex *of = h == 0 ? nullptr : &model.indices[std::abs(h) - 1];
        for (int j = 0; j < 2; ++j) add(0, of ? of->mxa[i * 2 + j] : model.mxa[i * 2 + j], motion(j));
        for (int j = 0; j < 9; ++j)
          add(of ? of->kxx[i * 9 + j] : model.kxx[i * 9 + j], of ? of->mxx[i * 9 + j] : model.mxx[i * 9 + j],
              motion(2 + j));
        sum -= of_index(of ? of->loads[0].fx[i] : model.loads[0].fx[i]) * course;
        EXPECT_LT(std::abs(amplitude(own + (layout.own_modes.size() + i) * n) - sum), 1e-13) << "harmonic " << k;
      }
      if (layout.size > 1 || h == 0) continue; // rows of modes want columns of all ranks
      const SectorIndex &of = model.indices[std::abs(h) - 1];
      for (int j = 0; j < 2; ++j) {
        Complex sum = (of.kaa[j] * damped - z2) * motion(j) - of_index(of.loads[0].fa[j]) * course;
        for (int i = 0; i < 9; ++i) sum -= z2 * of_index(std::conj(of.mxa[i * 2 + j])) * motion(2 + i);
        EXPECT_LT(std::abs(amplitude(own + j * n) - sum), 1e-13) << "harmonic " << k;
      }
    }
    check(VecRestoreArrayRead(f, &own), "");
  }
}

TEST(SectorAssembled, more_and_fewer_harmonics_are_of_their_own_indices) {
  HarmonicSystem system = sector_system(1);
  for (const int other : {2, 9}) {
    HarmonicSystem like(system, other, exactly);
    const UniqueVec y = vector_of(like, 0.3, 5, 1.1);
    EXPECT_LT(directional_error(like, y, vector_of(like, 1, 9, 0.4)), 1e-8);
    // what only the harmonics in common move is the same
    const int common = std::min(other, harmonics);
    const auto without_the_rest = [&](HarmonicSystem &of) {
      std::vector<double> q(static_cast<std::size_t>(of.layout().dofs()) * of.layout().width);
      for (PetscInt d = 0; d < of.layout().dofs(); ++d)
        for (int i = 0; i < coefficient_count(common); ++i) q[d * of.layout().width + i] = 1e-4 * wave(d, i);
      UniqueVec z = of.unknowns();
      set_coefficients(of.layout(), q, z);
      if (of.layout().owns_omega()) check(VecSetValue(z, of.layout().omega_row(), 1.1, INSERT_VALUES), "");
      check(VecAssemblyBegin(z), ""), check(VecAssemblyEnd(z), "");
      UniqueVec f = of.unknowns();
      of.residual(z, f);
      const std::vector<double> all = all_coefficients(of.layout(), f);
      std::vector<double> kept;
      for (PetscInt d = 0; d < of.layout().dofs(); ++d)
        for (int i = 0; i < coefficient_count(common); ++i) kept.push_back(all[d * of.layout().width + i]);
      return kept;
    };
    const std::vector<double> a = without_the_rest(system), b = without_the_rest(like);
    for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], 1e-12);
  }
}

// Twice as many as in single precision: of a mode in one harmonic four products for each pair of the contacts' rows,
// cosine and sine, and then of all these rows, which are coupled in all harmonics.
TEST(SectorAssembled, work_is_that_of_all_factors_since_it_was_asked_for) {
  HarmonicSystem system = sector_system(1);
  const UniqueMat J = system.matrix();
  const UniqueVec y = vector_of(system, 0.3, 5, 1.3), border = vector_of(system, 1, 7, 0.2);
  const double rows = 2 * 9, all = 9 * (2 * harmonics + 1),
               wanted = 2 * (2 * harmonics * 4 * rows * rows + 2 * std::pow(all, 3) / 3);
  for (const int fills : {1, 2}) {
    for (int i = 0; i < fills; ++i) system.jacobian(y, border, J);
    EXPECT_NEAR(system.take_solver_work(J), fills * wanted, 1e-9 * wanted);
    EXPECT_EQ(system.take_solver_work(J), 0);
  }
  EXPECT_THROW(system.couplings(), ComputeError);
}

// One of the mean, and of another index two, by real and by imaginary parts.
TEST(SectorAssembled, loads_are_those_of_indices_in_which_they_work) {
  for (const auto &[series, count] : {std::pair(std::vector<double>{0, 1}, 2u),
                                      {{0, 0, 1}, 2},
                                      {{0.2, 1, 0.3}, 3},
                                      {{0, 1, 0, 0, 1}, 4},
                                      {{0, 1, 0, 0, 0, 0, 0, 0, 0, 1}, 2}, // index -1
                                      {{0.2}, 1},
                                      {{}, 0}}) {
    ScaledModel made = scaled({small_sector(), {}, {}}, 0.05, {});
    made.engine_order = 1;
    made.model.contact = small_contact(made.model.reduced), made.model.standstill.resize(made.model.contact.size());
    const HarmonicSystem system(std::move(made), 6, exactly, course(series));
    EXPECT_EQ(system.loads().size(), count) << series.size();
    for (const LoadCase &load : system.loads()) EXPECT_EQ(load.fourier.size(), 13u);
  }
}

TEST(SectorAssembled, residual_is_the_same_in_other_units) {
  const Scales s{2.0, 1.4, 0.65};
  HarmonicSystem plain = sector_system(1), other = sector_system(1, exactly, {}, 0.05, s);
  UniqueVec y = vector_of(plain, 0.3, 5, 1.3), z = vector_of(other, 0.3, 5, 1.3 / s.frequency), f = plain.unknowns(),
            g = plain.unknowns();
  const PetscInt modal = plain.layout().own_modes.size() * plain.layout().width,
                 all = plain.layout().own_coefficients();
  double *own;
  check(VecGetArray(z, &own), "");
  for (PetscInt i = 0; i < all; ++i) own[i] /= i < modal ? s.modal : s.contact;
  check(VecRestoreArray(z, &own), "");
  plain.residual(y, f), other.residual(z, g);
  const double *a, *b, w2 = s.frequency * s.frequency;
  check(VecGetArrayRead(f, &a), "");
  check(VecGetArrayRead(g, &b), "");
  for (PetscInt i = 0; i < all; ++i)
    EXPECT_NEAR(a[i], b[i] * (i < modal ? s.modal * w2 : s.modal * s.modal * w2 / s.contact), 1e-12);
  check(VecRestoreArrayRead(f, &a), "");
  check(VecRestoreArrayRead(g, &b), "");
}

TEST(TravellingWave, index_is_the_nodal_diameter_with_its_sense) {
  const auto indices = [](int n, int engine_order) {
    std::vector<int> out;
    for (int k = 0; k <= 6; ++k) out.push_back(TravellingWave{n, engine_order}.index(k));
    return out;
  };
  EXPECT_EQ(indices(6, 1), (std::vector<int>{0, 1, 2, 3, -2, -1, 0}));
  EXPECT_EQ(indices(6, -1), (std::vector<int>{0, -1, -2, 3, 2, 1, 0}));
  EXPECT_EQ(indices(5, 3), (std::vector<int>{0, -2, 1, -1, 2, 0, -2}));
  EXPECT_EQ(indices(2, 7), (std::vector<int>{0, 1, 0, 1, 0, 1, 0}));
  EXPECT_EQ(indices(6, 13), indices(6, 1));
}

TEST(SectorAssembled, derivatives_of_a_peak_by_load_and_damping) { // against peaks climbed anew
  HarmonicSystem system = sector_system(1);
  const Watched watched{0, {}}; // the first mode
  PeakEquations peak(system, watched);
  double best = 0, at = 0;
  for (double w = 0.6; w < 1.6; w += 0.02) {
    peak.take(vector_of(system, 0, 1, w));
    if (peak.solve() && peak.differentiate() && peak.amplitude() > best) best = peak.amplitude(), at = w;
  }
  const auto climbed = [&](const char *parameter, double value) {
    peak.set(*parameter_named(parameter), value, nullptr);
    peak.take(vector_of(system, 0, 1, at));
    EXPECT_TRUE(peak.solve() && peak.climb()) << parameter << " " << value;
    return std::pair(peak.amplitude(), peak.omega());
  };
  climbed("force", 1);
  UniqueVec there = system.unknowns();
  check(VecCopy(peak.y(), there), "");
  const std::optional<PeakSensitivity> found = peak_sensitivity(system, there, watched);
  ASSERT_TRUE(found);
  const double h = 1e-4;
  for (const char *parameter : {"force", "damping"}) {
    const bool force = parameter == std::string("force");
    const auto [a, b] = std::pair(climbed(parameter, 1 - h), climbed(parameter, 1 + h));
    const double amplitude = (b.first - a.first) / (2 * h), omega = (b.second - a.second) / (2 * h);
    EXPECT_NEAR(force ? found->amplitude_by.force : found->amplitude_by.damping, amplitude, 1e-4 * std::abs(amplitude));
    EXPECT_NEAR(force ? found->omega_by.force : found->omega_by.damping, omega, 1e-4 * std::abs(omega));
    EXPECT_GT(std::abs(omega), 1e-4) << parameter;
  }
}

TEST(SectorAssembled, derivatives_of_a_followed_peak) {       // by motion, frequency and every parameter
  std::vector<std::vector<Complex>> factors(sectors / 2 + 1); // of a node, by index; the one dof is the first mode
  for (int h = 0; h <= sectors / 2; ++h)
    for (int d = 0; d < 11; ++d) factors[h].emplace_back(wave(d, 50 + h), h == 0 ? 0 : wave(d, 70 + h));
  const Watched dof{0, {}}, node{-1, WatchedRow(factors, {sectors, 1})};
  for (const auto &[watched, phase] : {std::pair(&dof, false), {&node, false}, {&dof, true}})
    for (const PathParameter &parameter : all_parameters) {
      if (&parameter == &frequency_parameter()) continue;
      if (!alone() && parameter.name != std::string("friction")) continue;
      ReducedModel model = small_sector();
      std::vector<ContactPoint> contact = small_contact(model);
      std::string note;
      const std::vector<double> zero(model.own_contact_dofs(), 0.0);
      PreloadedModel preloaded = contact_preload(std::move(model), std::move(contact), zero, note);
      const auto preload = std::make_shared<VariedPreload>(preloaded);
      ScaledModel made = scaled(std::move(preloaded), 0.05, {});
      made.engine_order = 1;
      HarmonicSystem system(std::move(made), harmonics, exactly, course(fourier));
      PeakEquations peak(system, *watched);
      std::unique_ptr<TrackCondition> condition;
      if (phase)
        condition = std::make_unique<PhaseResonance>(peak);
      else
        condition = std::make_unique<Extremum>(peak);
      PeakTrack track(peak, parameter, preload, *condition, 0.1);
      const double p = parameter.positive() ? 1.1 : 0.02, h = 1e-5;
      for (const double size : {0.06, 0.6}) {
        const auto point = [&](int seed, double w, double value) {
          UniqueVec y = track.unknowns();
          peak.take(vector_of(system, seed == 4 ? size : 1, seed, w));
          track.give(value, y);
          return y;
        };
        const UniqueVec y = point(4, 1.3, p), v = point(5, 0.4, 0.3);
        UniqueVec f = track.unknowns(), slope = track.unknowns(), there = track.unknowns(), product = track.unknowns();
        for (const double side : {1.0, -1.0}) {
          check(VecWAXPY(there, side * h, v, y), "");
          check(VecSet(f, 0), "");
          track.residual(there, f);
          check(VecAXPY(slope, side / (2 * h), f), "");
        }
        const auto jacobian = track.jacobian();
        jacobian->assemble(y, track.unknowns());
        check(MatMult(jacobian->matrix(), v, product), "");
        EXPECT_NEAR(track.omega_of(slope), track.omega_of(product), 2e-5 * std::abs(track.omega_of(product)))
            << parameter.name << ", motion " << size << ", phase " << phase;
        EXPECT_LT(relative_difference(slope, product), 2e-5)
            << parameter.name << ", motion " << size << ", phase " << phase;
      }
    }
}

TEST(WatchedRow, of_a_sector_has_another_factor_in_every_harmonic) {
  const TravellingWave travelling{6, 2}; // indices 0, 2, -2, 0, 2
  std::vector<std::vector<Complex>> factors(4, std::vector<Complex>(2));
  for (int h = 0; h < 4; ++h)
    for (int d = 0; d < 2; ++d) factors[h][d] = {0.3 + h - d, h == 0 ? 0 : 0.7 * h + d};
  WatchedRow row(factors, travelling);
  row.scale(1, 3);
  std::vector<double> c, sum(9, 0.0), back(9, 0.0), other;
  for (int i = 0; i < 9; ++i) c.push_back(wave(i, 1)), other.push_back(wave(i, 2));
  row.add(1, c.data(), 9, sum.data());
  EXPECT_NEAR(sum[0], 3 * factors[0][1].real() * c[0], 1e-15);
  for (int k = 1; k <= 4; ++k) {
    const int h = travelling.index(k);
    const Complex f = h < 0 ? std::conj(factors[-h][1]) : factors[h][1], moved = f * Complex(c[cosine(k)], -c[sine(k)]);
    EXPECT_NEAR(sum[cosine(k)], 3 * moved.real(), 1e-14);
    EXPECT_NEAR(sum[sine(k)], -3 * moved.imag(), 1e-14);
  }
  row.add_transposed(1, other.data(), 9, back.data());
  double there = 0, here = 0;
  for (int i = 0; i < 9; ++i) there += sum[i] * other[i], here += back[i] * c[i];
  EXPECT_NEAR(there, here, 1e-14);
}
