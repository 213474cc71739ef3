// Reduced files: all that is written comes back, datasets stand where the reference says, and what does not fit is
// refused in words. On any number of ranks.
#include <gtest/gtest.h>

#include <map>

#include "reduction/reduced_model.hpp"
#include "small_model.hpp"
#include "support/error.hpp"
#include "support/hdf5.hpp"
#include "temporary_file.hpp"

using namespace dovetail;
using namespace dovetail::testing;
using h5::Extent;

namespace {

// Two contact points and two modes, as somebody else would write them; rank 0 does.
struct Contents {
  std::map<std::string, std::pair<Extent, std::vector<double>>> sets;
  std::map<std::string, std::string> texts = {{"format", "dovetail-reduced"}};
  std::map<std::string, long> numbers = {{"version", 1}};
  std::vector<std::string> names;

  Contents() {
    const auto symmetric = [](double diagonal, int seed) {
      std::vector<double> values;
      for (int i = 0; i < 6; ++i)
        for (int j = 0; j < 6; ++j)
          values.push_back((i == j ? diagonal : 0) + wave(std::min(i, j), seed + std::max(i, j)));
      return values;
    };
    sets["/Kaa"] = {{2}, {4, 9}}, sets["/Max"] = {{2, 6}, {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12}};
    sets["/Kxx"] = {{6, 6}, symmetric(20, 0)}, sets["/Mxx"] = {{6, 6}, symmetric(2, 20)};
    sets["/Fa"] = {{2}, {0.5, -0.5}}, sets["/Fx"] = {{6}, {1, 0, -1, 2, 0, -2}};
    sets["/R"] = {{6}, {0.1, 0.2, 0.3, 0.4, 0.5, 0.6}};
  }
  double &at(const std::string &name, std::size_t place) { return sets.at(name).second.at(place); }
  void with(const std::string &name, const Extent &shape, double first = 1) {
    std::size_t count = 1;
    for (const hsize_t n : shape) count *= n;
    std::vector<double> values(count);
    for (std::size_t i = 0; i < count; ++i) values[i] = first + static_cast<double>(i);
    sets[name] = {shape, values};
  }
  void two_patterns() {
    names = {"one", "two"};
    with("/Fa", {2, 2}), with("/Fx", {2, 6}, 10);
  }
  void left_out(const Extent &fa = {3}) {
    with("/left_out/Kaa", {3}), with("/left_out/Fa", fa, 20), with("/left_out/Max", {3, 6}, 30);
    with("/left_out/Maa", {2, 3}, 50);
  }

  void write(const std::filesystem::path &path) const {
    MPI_Barrier(PETSC_COMM_WORLD); // it may still be read
    if (rank_here() == 0) {
      h5::Writer file(path);
      for (const auto &[name, text] : texts) file.attribute(name, text);
      for (const auto &[name, number] : numbers) file.attribute(name, number);
      if (!names.empty()) file.attribute("force_names", names);
      for (const auto &[name, set] : sets) {
        std::vector<double> values = set.second;
        values.resize(values.size() + 1);
        file.rows(name, set.first, 0, set.first[0], values.data());
      }
      file.close();
    }
    MPI_Barrier(PETSC_COMM_WORLD);
  }
};

using Change = std::function<void(Contents &)>;

ReducedModel read(const TemporaryFile &file, const Change &change = {}) {
  Contents contents;
  if (change) change(contents);
  contents.write(file.path);
  return read_reduced(PETSC_COMM_WORLD, file.path);
}

// Own rows of an array that stands whole in a file, `columns` numbers a row.
std::vector<double> own_rows(const ReducedModel &model, const std::vector<double> &whole, PetscInt columns) {
  return {whole.begin() + 3 * model.own_points.begin * columns, whole.begin() + 3 * model.own_points.end * columns};
}

std::vector<double> transposed(const std::vector<double> &A, int m, int n) {
  std::vector<double> out;
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < m; ++i) out.push_back(A[i * n + j]);
  return out;
}

std::vector<double> counted(double first, int count) {
  std::vector<double> values;
  for (int i = 0; i < count; ++i) values.push_back(first + i);
  return values;
}

Reduction of_everything() {
  Reduction made;
  ReducedModel &model = made.model = small_reduced(PETSC_COMM_WORLD);
  Damping damping;
  damping.matrix = damping.of_parts = true;
  add_damping_matrices(damping, model);
  model.units = "mm-N-s";
  model.loads.push_back({"second", {0.1, 0.2}, model.r});
  const int own = model.own_contact_dofs(), first = 3 * model.own_points.begin;
  LeftOut &left = model.left_out;
  left.squares = {9, 16, 25}, left.loads = {{1, 2, 3}, {4, 5, 6}}, left.with_modes = counted(1, 6);
  for (int i = 0; i < 3 * own; ++i) left.coupling.push_back(wave(3 * first + i, 7));
  Recovery &recovery = made.recovery;
  for (int i = 0; i <= rank_here(); ++i) { // another number on each rank
    recovery.elastic_dofs.push_back(100 * rank_here() + i), recovery.xe0.push_back(wave(rank_here(), i));
    for (int j = 0; j < 2; ++j) recovery.phi.push_back(wave(10 * rank_here() + i, j));
    for (int j = 0; j < 9; ++j) recovery.psi.push_back(wave(10 * rank_here() + i, 30 + j));
  }
  model.fingerprint = fingerprint_of(model);
  return made;
}

Source some_source() {
  Source source;
  source.file = "bar.h5", source.hash = 0xabc, source.units = "mm-N-s", source.modes = 2, source.motion = "all";
  source.ordering = "METIS", source.contact_dofs = {{5, 4, 3}, {8, 7, 6}, {0, 1, 2}}, source.area = {0.5, 1.5, 2.5};
  return source;
}

} // namespace

TEST(ReducedFile, comes_back_to_the_last_bit) {
  const TemporaryFile file("everything");
  const Reduction made = of_everything();
  write_reduced(file.path, some_source(), made);
  const ReducedModel &wanted = made.model, found = read_reduced(PETSC_COMM_WORLD, file.path);
  EXPECT_TRUE(found.as_written);
  EXPECT_EQ(found.fingerprint, wanted.fingerprint);
  EXPECT_EQ(found.units, "mm-N-s");
  EXPECT_EQ(found.modes, 2);
  EXPECT_EQ(found.points, 3);
  EXPECT_EQ(found.own_points.begin, wanted.own_points.begin);
  EXPECT_EQ(found.own_modes.end, wanted.own_modes.end);
  EXPECT_EQ(found.sectors, 0);
  EXPECT_EQ(found.kaa, wanted.kaa);
  EXPECT_EQ(found.mxa, wanted.mxa);
  EXPECT_EQ(found.mxx, wanted.mxx);
  EXPECT_EQ(found.kxx, wanted.kxx);
  EXPECT_EQ(found.r, wanted.r);
  ASSERT_EQ(found.loads.size(), 2u);
  for (int j = 0; j < 2; ++j) {
    EXPECT_EQ(found.loads[j].name, wanted.loads[j].name);
    EXPECT_EQ(found.loads[j].fa, wanted.loads[j].fa);
    EXPECT_EQ(found.loads[j].fx, wanted.loads[j].fx);
  }
  for (const auto matrix : {&ReducedModel::viscous, &ReducedModel::structural}) {
    EXPECT_TRUE((found.*matrix).given);
    EXPECT_EQ((found.*matrix).aa, (wanted.*matrix).aa);
    EXPECT_EQ((found.*matrix).xa, (wanted.*matrix).xa);
    EXPECT_EQ((found.*matrix).xx, (wanted.*matrix).xx);
  }
  EXPECT_EQ(found.left_out.squares, wanted.left_out.squares);
  EXPECT_EQ(found.left_out.loads, wanted.left_out.loads);
  EXPECT_EQ(found.left_out.coupling, wanted.left_out.coupling);
  EXPECT_EQ(found.left_out.with_modes, wanted.left_out.with_modes);
  EXPECT_EQ(found.load("force"), 0u);
  EXPECT_EQ(found.load("second"), 1u);
  EXPECT_EQ(said<InputError>([&] { found.load("third"); }),
            "load pattern \"third\": the reduced model has only \"force\", \"second\"");
  const ReducedHeader header = read_reduced_header(file.path);
  EXPECT_EQ(header.modes, 2);
  EXPECT_EQ(header.points, 3);
  EXPECT_EQ(header.loads, (std::vector<std::string>{"force", "second"}));
  EXPECT_TRUE(header.has_c && header.has_structural);
  EXPECT_EQ(header.area, some_source().area);
  EXPECT_EQ(header.units, "mm-N-s");
  EXPECT_EQ(header.sectors, 0);
}

TEST(ReducedFile, says_where_it_comes_from_and_what_moves) {
  const TemporaryFile file("places");
  const Reduction made = of_everything();
  write_reduced(file.path, some_source(), made);
  EXPECT_FALSE(std::filesystem::exists(file.path.string() + ".partial"));
  const h5::Reader reader(file.path);
  EXPECT_EQ(reader.text_attribute("format"), "dovetail-reduced");
  EXPECT_EQ(reader.integer_attribute("version", 0), 1);
  EXPECT_EQ(reader.text_attribute("source"), "0000000000000abc with 2 modes, method 5, motion all, units mm-N-s");
  EXPECT_EQ(reader.text_attribute("fingerprint"), made.model.fingerprint);
  EXPECT_EQ(reader.text_attribute("units"), "mm-N-s");
  EXPECT_EQ(reader.text_attribute("model"), "bar.h5");
  EXPECT_EQ(reader.text_attribute("program").find("dovetail "), 0u);
  EXPECT_EQ(reader.text_attribute("ordering"), "METIS");
  EXPECT_EQ(reader.integer_attribute("modes_counted", -1), 0);
  EXPECT_EQ(reader.extent("/Max"), (Extent{2, 9}));
  EXPECT_EQ(reader.extent("/Fa"), (Extent{2, 2}));
  EXPECT_EQ(reader.extent("/Cax"), (Extent{2, 9}));
  EXPECT_EQ(reader.extent("/left_out/Max"), (Extent{3, 9}));
  EXPECT_EQ(reader.extent("/left_out/Maa"), (Extent{2, 3}));
  EXPECT_EQ(reader.integers("/recovery/contact_dofs"), (std::vector<long>{5, 4, 3, 8, 7, 6, 0, 1, 2}));
  EXPECT_EQ(reader.extent("/recovery/contact_dofs"), (Extent{3, 3}));
  EXPECT_EQ(reader.doubles("/contact/area"), some_source().area);
  int ranks;
  MPI_Comm_size(PETSC_COMM_WORLD, &ranks);
  std::vector<long> dofs;
  std::vector<double> xe0, phi, psi;
  for (int rank = 0; rank < ranks; ++rank)
    for (int i = 0; i <= rank; ++i) {
      dofs.push_back(100 * rank + i), xe0.push_back(wave(rank, i));
      for (int j = 0; j < 2; ++j) phi.push_back(wave(10 * rank + i, j));
      for (int j = 0; j < 9; ++j) psi.push_back(wave(10 * rank + i, 30 + j));
    }
  EXPECT_EQ(reader.integers("/recovery/elastic_dofs"), dofs);
  EXPECT_EQ(reader.doubles("/recovery/xe0"), xe0);
  EXPECT_EQ(reader.doubles("/recovery/Phi"), phi);
  EXPECT_EQ(reader.doubles("/recovery/Psi"), psi);
}

TEST(ReducedFile, with_the_usual_load_alone_has_no_names_and_no_area_or_damping_it_was_not_given) {
  const TemporaryFile file("usual");
  Reduction made;
  made.model = small_reduced(PETSC_COMM_WORLD);
  Source source = some_source();
  source.area.clear();
  write_reduced(file.path, source, made);
  {
    const h5::Reader reader(file.path);
    EXPECT_TRUE(reader.words_attribute("force_names").empty());
    EXPECT_EQ(reader.extent("/Fa"), (Extent{2}));
    EXPECT_EQ(reader.extent("/Fx"), (Extent{9}));
    for (const char *name : {"/Caa", "/Saa", "/left_out", "/contact", "/cyclic"})
      EXPECT_FALSE(reader.has(name)) << name;
  }
  const ReducedModel found = read_reduced(PETSC_COMM_WORLD, file.path);
  EXPECT_TRUE(found.as_written); // it has no fingerprint
  EXPECT_FALSE(found.viscous.given || found.structural.given);
  EXPECT_EQ(found.loads[0].name, "force");
  EXPECT_TRUE(found.left_out.squares.empty());
  MPI_Barrier(PETSC_COMM_WORLD);
  made.model.loads[0].name = "wind", made.model.fingerprint = "of others";
  write_reduced(file.path, source, made);
  const ReducedModel renamed = read_reduced(PETSC_COMM_WORLD, file.path);
  EXPECT_EQ(renamed.loads[0].name, "wind");
  EXPECT_FALSE(renamed.as_written);
}

TEST(ReducedFile, matches_just_what_it_was_made_from) {
  const TemporaryFile file("matches");
  const Reduction made = of_everything();
  const Source source = some_source();
  const auto match = [&](const Source &wanted) { return matches(PETSC_COMM_WORLD, file.path, wanted); };
  EXPECT_FALSE(match(source)); // there is none
  write_reduced(file.path, source, made);
  EXPECT_TRUE(match(source));
  using Part = std::function<void(Source &)>;
  for (const Part &change :
       {Part([](Source &s) { s.hash = 1; }), Part([](Source &s) { s.modes = 3; }),
        Part([](Source &s) { s.kind = ModeKind::residual; }), Part([](Source &s) { s.modes_counted = true; }),
        Part([](Source &s) { s.motion = "2 dofs"; }), Part([](Source &s) { s.units = "SI"; }),
        Part([](Source &s) { s.interior_modes = 4; })}) {
    Source other = source;
    change(other);
    EXPECT_FALSE(match(other));
  }
  Source same = source;
  same.exact_modes = true; // of no sector
  EXPECT_TRUE(match(same));
  MPI_Barrier(PETSC_COMM_WORLD);
  Source sector = source;
  sector.interior_modes = 4, sector.kind = ModeKind::residual, sector.modes_counted = true;
  write_reduced(file.path, sector, made);
  EXPECT_TRUE(match(sector));
  EXPECT_EQ(h5::Reader(file.path).text_attribute("source"),
            "0000000000000abc with 2 modes with residuals, method 5, motion 4 interior, and what they leave out, all, "
            "units mm-N-s");
  sector.modes_counted = false; // more than is wanted
  EXPECT_TRUE(match(sector));
  sector.exact_modes = true;
  EXPECT_FALSE(match(sector));
  MPI_Barrier(PETSC_COMM_WORLD);
  write_reduced(file.path, sector, made);
  EXPECT_EQ(h5::Reader(file.path).text_attribute("source"),
            "0000000000000abc with 2 modes with residuals, method 5, motion 4 interior, exact, and what they leave "
            "out, all, units mm-N-s");
  EXPECT_NO_THROW(check_replaceable(file.path));
  Contents().write(file.path); // of others
  EXPECT_FALSE(match(sector));
  EXPECT_EQ(said<InputError>([&] { check_replaceable(file.path); }),
            file.path.string() +
                ": this file was not made by dovetail, but the reduced model is to be written there; move it away, or "
                "name another folder with output.directory or --out");
  MPI_Barrier(PETSC_COMM_WORLD);
  if (rank_here() == 0) std::filesystem::resize_file(file.path, 5);
  MPI_Barrier(PETSC_COMM_WORLD);
  EXPECT_NO_THROW(check_replaceable(file.path)); // damaged
  EXPECT_NO_THROW(check_replaceable(file.path.string() + ".none"));
}

TEST(ReducedFile, of_others_is_read_row_by_row) {
  const TemporaryFile file("others");
  const Contents whole;
  const ReducedModel model = read(file);
  const auto values = [&](const char *name) { return whole.sets.at(name).second; };
  EXPECT_EQ(model.units, "SI");
  EXPECT_TRUE(model.as_written);
  EXPECT_EQ(model.modes, 2);
  EXPECT_EQ(model.points, 2);
  EXPECT_EQ(model.kaa, values("/Kaa"));
  EXPECT_EQ(model.kxx, own_rows(model, values("/Kxx"), 6));
  EXPECT_EQ(model.mxx, own_rows(model, values("/Mxx"), 6));
  EXPECT_EQ(model.mxa, own_rows(model, transposed(values("/Max"), 2, 6), 2));
  EXPECT_EQ(model.r, own_rows(model, values("/R"), 1));
  ASSERT_EQ(model.loads.size(), 1u);
  EXPECT_EQ(model.loads[0].name, "force");
  EXPECT_EQ(model.loads[0].fa, values("/Fa"));
  EXPECT_EQ(model.loads[0].fx, own_rows(model, values("/Fx"), 1));
  const ReducedModel two = read(file, [](Contents &c) {
    c.two_patterns(), c.left_out({2, 3}), c.texts["units"] = "mm";
  });
  EXPECT_EQ(two.units, "mm");
  ASSERT_EQ(two.loads.size(), 2u);
  EXPECT_EQ(two.loads[1].name, "two");
  EXPECT_EQ(two.loads[1].fa, (std::vector<double>{3, 4}));
  EXPECT_EQ(two.loads[1].fx, own_rows(two, counted(16, 6), 1));
  EXPECT_EQ(two.left_out.loads, (std::vector<std::vector<double>>{{20, 21, 22}, {23, 24, 25}}));
  const ReducedModel one = read(file, [](Contents &c) { // one of several
    c.names = {"one"}, c.with("/Fa", {1, 2}), c.with("/Fx", {1, 6}), c.left_out({1, 3});
  });
  EXPECT_EQ(one.loads[0].name, "one");
  EXPECT_EQ(one.loads[0].fa, (std::vector<double>{1, 2}));
  EXPECT_EQ(one.left_out.loads[0], (std::vector<double>{20, 21, 22}));
}

TEST(ReducedFile, with_modes_or_contact_points_alone) {
  const TemporaryFile file("alone");
  const ReducedModel modes = read(file, [](Contents &c) {
    for (const char *name : {"/Kxx", "/Mxx"}) c.with(name, {0, 0});
    for (const char *name : {"/Fx", "/R"}) c.with(name, {0});
    c.with("/Max", {2, 0});
  });
  EXPECT_EQ(modes.points, 0);
  EXPECT_EQ(modes.kaa, (std::vector<double>{4, 9}));
  const ReducedModel points = read(file, [](Contents &c) {
    for (const char *name : {"/Kaa", "/Fa"}) c.with(name, {0});
    c.with("/Max", {0, 6});
    c.left_out();
    c.sets.erase("/left_out/Maa");
  });
  EXPECT_EQ(points.modes, 0);
  EXPECT_TRUE(points.left_out.with_modes.empty());
  EXPECT_EQ(points.left_out.squares, counted(1, 3));
}

TEST(ReducedFile, what_it_leaves_out) {
  const TemporaryFile file("left_out");
  const ReducedModel model = read(file, [](Contents &c) { c.left_out(); });
  const LeftOut &left = model.left_out;
  EXPECT_EQ(left.squares, counted(1, 3));
  EXPECT_EQ(left.loads, (std::vector<std::vector<double>>{{20, 21, 22}}));
  EXPECT_EQ(left.coupling, own_rows(model, transposed(counted(30, 18), 3, 6), 3));
  EXPECT_EQ(left.with_modes, counted(50, 6));
}

TEST(ReducedFile, damping_by_its_diagonal_or_in_part) {
  const TemporaryFile file("damping");
  const ReducedModel model = read(file, [](Contents &c) {
    c.with("/Caa", {2}, 5);
    c.sets["/Saa"] = {{2, 2}, {3, -1, -1, 4}}, c.with("/Sax", {2, 6}), c.sets["/Sxx"] = c.sets.at("/Kxx");
  });
  ASSERT_TRUE(model.viscous.given && model.structural.given);
  EXPECT_EQ(model.viscous.aa, (std::vector<double>{5, 0, 0, 6}));
  EXPECT_EQ(model.viscous.xa, std::vector<double>(2 * model.own_contact_dofs()));
  EXPECT_EQ(model.viscous.xx, std::vector<double>(6 * model.own_contact_dofs()));
  EXPECT_EQ(model.structural.aa, (std::vector<double>{3, -1, -1, 4}));
  EXPECT_EQ(model.structural.xa, own_rows(model, transposed(counted(1, 12), 2, 6), 2));
  EXPECT_EQ(model.structural.xx, model.kxx);
}

TEST(ReducedFile, symmetric_but_for_rounding_errors) {
  const TemporaryFile file("symmetric");
  double most = 0; // of the first rank's rows
  int ranks;
  MPI_Comm_size(PETSC_COMM_WORLD, &ranks);
  const Contents contents;
  for (int i = 0; i < 18 * share_of(2, 0, ranks).size(); ++i)
    most = std::max(most, std::abs(contents.sets.at("/Kxx").second[i]));
  const auto off = [&](const std::string &name, double by) {
    return said<InputError>([&] {
      read(file, [&](Contents &c) {
        c.sets["/Saa"] = {{2, 2}, {3, -1, -1, 4}}, c.sets["/Sxx"] = c.sets.at("/Kxx");
        c.at(name, 1) += by;
      });
    });
  };
  const std::string nothing = "nothing was thrown", where = file.path.string() + ": ";
  const std::string here = ": not symmetric, row 0, column 1 (of 0..)",
                    there = ": not symmetric, row 1, column 0 (of 0..)";
  for (const char *name : {"/Kxx", "/Sxx"}) {
    for (const double sign : {1.0, -1.0}) EXPECT_EQ(off(name, sign * 0.7e-8 * most), nothing) << name;
    for (const double sign : {1.0, -1.0}) EXPECT_EQ(off(name, sign * 1.5e-8 * most), where + name + here);
  }
  for (const double sign : {1.0, -1.0}) {
    EXPECT_EQ(off("/Saa", sign * 3.5e-8), nothing);
    EXPECT_EQ(off("/Saa", sign * 4.5e-8), where + "/Saa" + there);
  }
}

TEST(ReducedFile, what_does_not_fit_is_refused_in_words) {
  const TemporaryFile file("refused");
  const std::vector<std::pair<std::string, Change>> wrong = {
      {": attribute format is \"other\", \"dovetail-reduced\" wanted",
       [](Contents &c) { c.texts["format"] = "other"; }},
      {": attribute format is \"dovetail-model\", \"dovetail-reduced\" wanted; name a full model with  model =  "
       "instead "
       "of  reduced =",
       [](Contents &c) { c.texts["format"] = "dovetail-model"; }},
      {": version 2 of the reduced format; this program reads version 1",
       [](Contents &c) { c.numbers["version"] = 2; }},
      {": /Kaa: a list of the squared frequencies (N_a,) is wanted",
       [](Contents &c) {
         c.with("/Kaa", {2, 1});
       }},
      {": /Kxx: a square matrix with three rows (t1, t2, n) per contact point is wanted",
       [](Contents &c) { c.with("/Kxx", {36}); }},
      {": /Kxx: a square matrix with three rows (t1, t2, n) per contact point is wanted",
       [](Contents &c) {
         c.with("/Kxx", {6, 3});
       }},
      {": /Kxx: a square matrix with three rows (t1, t2, n) per contact point is wanted",
       [](Contents &c) {
         c.with("/Kxx", {5, 5});
       }},
      {": holds no mode and no contact point",
       [](Contents &c) {
         c.with("/Kaa", {0}), c.with("/Kxx", {0, 0});
       }},
      {": /Max: shape (6, 2) where (N_a, 3 N_x) = (2, 6) is wanted",
       [](Contents &c) {
         c.with("/Max", {6, 2});
       }},
      {": /Mxx: shape (3, 6) where (3 N_x, 3 N_x) = (6, 6) is wanted",
       [](Contents &c) {
         c.with("/Mxx", {3, 6});
       }},
      {": /Fa: shape (3) where (N_a,) = (2,) is wanted", [](Contents &c) { c.with("/Fa", {3}); }},
      {": /Fx: shape (5) where (3 N_x,) = (6,) is wanted", [](Contents &c) { c.with("/Fx", {5}); }},
      {": /R: shape (6, 1) where (3 N_x,) = (6,) is wanted",
       [](Contents &c) {
         c.with("/R", {6, 1});
       }},
      {": /Fa: shape (2, 3) where (patterns, N_a) = (2, 2) is wanted",
       [](Contents &c) {
         c.two_patterns(), c.with("/Fa", {2, 3});
       }},
      {": /Fx: shape (1, 6) where (patterns, 3 N_x) = (2, 6) is wanted",
       [](Contents &c) {
         c.two_patterns(), c.with("/Fx", {1, 6});
       }},
      {": /: attribute force_names has 0 names where /Fa has 2 load patterns; a name for each is wanted",
       [](Contents &c) { c.two_patterns(), c.names = {}; }},
      {": /: attribute force_names has 2 names where /Fa has 1 load patterns; a name for each is wanted",
       [](Contents &c) {
         c.names = {"one", "two"};
       }},
      {": /: attribute force_names has one name twice; another for each is wanted",
       [](Contents &c) {
         c.two_patterns(), c.names = {"one", "one"};
       }},
      {": /Caa: shape (3, 2) where (N_a, N_a) = (2, 2), or its diagonal (N_a,), is wanted",
       [](Contents &c) {
         c.with("/Caa", {3, 2});
       }},
      {": /Caa: shape (3) where (N_a,) = (2,) is wanted", [](Contents &c) { c.with("/Caa", {3}); }},
      {": /Caa: missing",
       [](Contents &c) {
         c.with("/Cax", {2, 6});
       }},
      {": /Saa: missing", [](Contents &c) { c.sets["/Sxx"] = c.sets.at("/Kxx"); }},
      {": /Cax: shape (2, 5) where (N_a, 3 N_x) = (2, 6) is wanted",
       [](Contents &c) {
         c.with("/Caa", {2}), c.with("/Cax", {2, 5});
       }},
      {": /Cxx: shape (6, 5) where (3 N_x, 3 N_x) = (6, 6) is wanted",
       [](Contents &c) {
         c.with("/Caa", {2}), c.with("/Cxx", {6, 5});
       }},
      {": /contact/area: shape (6) where (N_x,) = (2,) is wanted", [](Contents &c) { c.with("/contact/area", {6}); }},
      {": /Kaa: 0.000000; squared frequencies above 0 are wanted", [](Contents &c) { c.at("/Kaa", 1) = 0; }},
      {": /Kaa: inf; finite numbers are wanted", [](Contents &c) { c.at("/Kaa", 1) = INFINITY; }},
      {": /R: -inf; finite numbers are wanted", [](Contents &c) { c.at("/R", 1) = -INFINITY; }},
      {": /Fa: nan; finite numbers are wanted", [](Contents &c) { c.at("/Fa", 1) = NAN; }},
      {": /Fx: nan; finite numbers are wanted", [](Contents &c) { c.at("/Fx", 1) = NAN; }},
      {": /Kxx: nan; finite numbers are wanted", [](Contents &c) { c.at("/Kxx", 1) = NAN; }},
      {": /Max: nan; finite numbers are wanted", [](Contents &c) { c.at("/Max", 1) = NAN; }},
      {": /Caa: nan; finite numbers are wanted", [](Contents &c) { c.with("/Caa", {2}, NAN); }},
      {": /left_out/Kaa: nan; finite numbers are wanted",
       [](Contents &c) { c.left_out(), c.at("/left_out/Kaa", 0) = NAN; }},
      {": /left_out/Fa: nan; finite numbers are wanted",
       [](Contents &c) { c.left_out(), c.at("/left_out/Fa", 0) = NAN; }},
      {": /left_out/Maa: nan; finite numbers are wanted",
       [](Contents &c) { c.left_out(), c.at("/left_out/Maa", 0) = NAN; }},
      {": /left_out/Max: nan; finite numbers are wanted",
       [](Contents &c) { c.left_out(), c.at("/left_out/Max", 0) = NAN; }},
      {": /left_out/Kaa: squared frequencies above 0 are wanted",
       [](Contents &c) { c.left_out(), c.at("/left_out/Kaa", 0) = 0; }},
      {": /left_out/Maa: shape (N_a, r) is wanted", [](Contents &c) {
         c.left_out(), c.with("/left_out/Maa", {2, 2});
       }}};
  for (const auto &[words, change] : wrong)
    EXPECT_EQ(said<InputError>([&] { read(file, change); }), file.path.string() + words);
  const Change shapes[] = {[](Contents &c) { c.left_out({2}); },
                           [](Contents &c) {
                             c.left_out({2, 3});
                           },
                           [](Contents &c) {
                             c.left_out(), c.with("/left_out/Max", {2, 6});
                           },
                           [](Contents &c) {
                             c.left_out(), c.with("/left_out/Max", {3, 5});
                           },
                           [](Contents &c) { c.two_patterns(), c.left_out({3}); }};
  for (const Change &change : shapes)
    EXPECT_EQ(said<InputError>([&] { read(file, change); }),
              file.path.string() +
                  ": /left_out: shapes (r,), (r,) and (r, 3 N_x) are wanted of Kaa, Fa and Max; of several "
                  "load patterns, (patterns, r) of Fa");
}

TEST(ReducedFile, says_what_is_wrong_with_a_mass) {
  EXPECT_EQ(
      mass_not_positive("m.h5").find("m.h5: the reduced mass matrix, [1, Max; Max^T, Mxx], is not positive definite"),
      0u);
}
