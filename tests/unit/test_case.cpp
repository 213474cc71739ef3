// Reading case files: every complaint names the file, the line, the key and the value; good ones arrive
// complete.
#include "case/case.hpp"
#include "case/restart.hpp"
#include "case/toml_versions.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <sstream>

#include "app/forecast.hpp"
#include "support/error.hpp"

namespace dovetail {
namespace {

namespace fs = std::filesystem;

const std::vector<std::string> good_lines = {
    "title = \"test\"",                  // 1
    "model = \"model.h5\"",              // 2
    "",                                  // 3
    "[reduction]",                       // 4
    "modes = 2",                         // 5
    "[damping]",                         // 6
    "stiffness = 0.05",                  // 7
    "[excitation]",                      // 8
    "fourier = [0, 0, 1]",               // 9
    "[contact]",                         // 10
    "normal_stiffness = 1.0",            // 11
    "tangential_stiffness = [1.0, 2.0]", // 12
    "friction = [0.3, 0.4]",             // 13
    "gap = -3.5",                        // 14
    "[preload]",                         // 15
    "initial = 1e-5",                    // 16
    "[harmonic_balance]",                // 17
    "harmonics = 5",                     // 18
    "samples = 64",                      // 19
    "[newton]",                          // 20
    "step_tolerance = 1e-5",             // 21
    "residual_tolerance = 1e-6",         // 22
    "max_iterations = 50",               // 23
    "[scaling]",                         // 24
    "kind = \"none\"",                   // 25
    "[continuation]",                    // 26
    "omega = [0.9, 1.3]",                // 27
    "step = 0.05",                       // 28
    "adaptive = false",                  // 29
    "max_points = 300",                  // 30
    "at = [1.0, 1.1]",                   // 31
    "start = \"start.h5\"",              // 32
    "[output]",                          // 33
    "directory = \"out\"",               // 34
};

using Changes = std::vector<std::pair<size_t, std::string>>; ///< line from 1, its new text

class CaseFile : public ::testing::Test {
protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "dovetail-case-XXXXXX").string(); // every rank has its own
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    folder = name;
    for (const char *file : {"model.h5", "reduced.h5", "start.h5"}) std::ofstream(folder / file) << "x";
  }
  void TearDown() override { fs::remove_all(folder); }

  fs::path write(const std::string &text) const {
    std::ofstream(folder / "case.toml", std::ios::binary) << text;
    return folder / "case.toml";
  }
  fs::path write(const Changes &changes) const {
    auto lines = good_lines;
    for (const auto &[line, text] : changes) lines.at(line - 1) = text;
    std::string text;
    for (const auto &line : lines) text += line + "\n";
    return write(text);
  }
  Case read(const Changes &changes = {}) const { return read_case(write(changes), {}); }

  static void expect_words(const std::string &message, const std::vector<std::string> &words) {
    for (const auto &word : words) EXPECT_NE(message.find(word), std::string::npos) << message << "\n  lacks: " << word;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
  static std::string message_of(const std::function<void()> &work) {
    try {
      work();
    } catch (const InputError &error) {
      return error.what();
    }
    return "nothing was wrong";
  }
  /// The changed file is refused with the line of the fault, and `words`.
  void refused(const Changes &changes, size_t line, std::vector<std::string> words) const {
    words.push_back((folder / "case.toml").string() + (line ? ":" + std::to_string(line) : "") + ": ");
    expect_words(message_of([&] { read(changes); }), words);
  }
  void refused(size_t line, const std::string &text, const std::vector<std::string> &words) const {
    refused({{line, text}}, line, words);
  }

  fs::path folder;
};

TEST_F(CaseFile, EveryValueArrives) {
  const Case study = read();
  EXPECT_EQ(study.file, folder / "case.toml");
  EXPECT_NE(study.text.find("directory = \"out\""), std::string::npos);
  EXPECT_EQ(study.title, "test");
  EXPECT_EQ(study.model, folder / "model.h5");
  EXPECT_TRUE(study.reduced.empty());
  EXPECT_EQ(study.modes, 2);
  EXPECT_EQ(study.damping.stiffness, 0.05);
  EXPECT_EQ(study.loads[0].fourier, (std::vector<double>{0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0}));
  EXPECT_EQ(study.contact.normal_stiffness.value().values, std::vector<double>{1});
  EXPECT_FALSE(study.contact.normal_stiffness.value().pairs);
  EXPECT_EQ(study.contact.tangential_stiffness.value().values, (std::vector<double>{1, 2}));
  EXPECT_TRUE(study.contact.tangential_stiffness.value().pairs);
  EXPECT_EQ(study.contact.friction.value().where, (folder / "case.toml").string() + ":13: contact.friction");
  EXPECT_EQ(study.contact.gap.value().values, std::vector<double>{-3.5});
  EXPECT_EQ(study.preload_initial, std::vector<double>{1e-5});
  EXPECT_EQ(study.harmonics, 5);
  EXPECT_EQ(study.samples, 64);
  EXPECT_EQ(study.step_tolerance, 1e-5);
  EXPECT_EQ(study.residual_tolerance, 1e-6);
  EXPECT_EQ(study.max_iterations, 50);
  EXPECT_EQ(study.scaling, ScalingKind::none);
  EXPECT_EQ(study.omega_from, 0.9);
  EXPECT_EQ(study.omega_to, 1.3);
  EXPECT_EQ(study.step, 0.05);
  EXPECT_FALSE(study.adaptive);
  EXPECT_EQ(study.max_points, 300);
  EXPECT_EQ(study.at, (std::vector<double>{1.0, 1.1}));
  EXPECT_EQ(study.start, folder / "start.h5");
  EXPECT_EQ(study.directory, folder / "out");
}

TEST_F(CaseFile, ShortestFileTakesDefaults) {
  const Case study = read_case(write("reduced = \"reduced.h5\"\nexcitation.fourier = [0, 1]\n"
                                     "harmonic_balance.harmonics = 10\ncontinuation.omega = [5, 2]"),
                               {});
  EXPECT_EQ(study.reduced, folder / "reduced.h5");
  EXPECT_EQ(study.damping.stiffness, 0);
  EXPECT_EQ(study.samples, 0); // exact
  EXPECT_EQ(study.contact.law.values, std::vector<Law>{Law::coulomb});
  EXPECT_EQ(study.preload_initial, std::vector<double>{0});
  EXPECT_EQ(study.scaling, ScalingKind::automatic);
  EXPECT_EQ(study.step_tolerance, 1e-8);
  EXPECT_TRUE(study.adaptive);
  EXPECT_EQ(study.omega_from, 5);
  EXPECT_EQ(study.directory, folder);
  EXPECT_FALSE(study.contact.gap);
}

TEST_F(CaseFile, GoodVariants) {
  EXPECT_EQ(read({{19, "samples = \"exact\""}}).samples, 0);
  EXPECT_EQ(read({{19, "samples = 11"}}).samples, 11);
  EXPECT_EQ(read({{9, "fourier = [0.5, 1]"}}).loads[0].fourier.front(), 0.5);
  EXPECT_EQ(read({{9, "fourier = [0, 0, 1, 0, 0]"}, {18, "harmonics = 1"}}).loads[0].fourier,
            (std::vector<double>{0, 0, 1}));
  EXPECT_EQ(read({{9, "fourier = [0, 1, 0, 2]"}, {18, "harmonics = 2"}}).loads[0].fourier,
            (std::vector<double>{0, 1, 0, 2, 0}));
  EXPECT_EQ(read({{5, "modes = 0"}}).modes, 0);
  EXPECT_EQ(read({{27, "omega = [1, 1]"}, {31, "at = [1.0]"}}).omega_to, 1);
  EXPECT_EQ(read({{27, "omega = [1.3, 0.9]"}, {31, "at = [1.1,\n 1.0]"}}).at.back(), 1.0);
  EXPECT_EQ(read({{11, "normal_stiffness = 1_000"}}).contact.normal_stiffness.value().values.front(), 1000);
  const Case manual = read({{25, "kind = \"manual\"\nfrequency = 2\nmodal = 3.0\ncontact = 1e-6"}});
  EXPECT_EQ(manual.scaling, ScalingKind::manual);
  EXPECT_EQ(manual.scale_frequency, 2);
  EXPECT_EQ(manual.scale_modal, 3);
  EXPECT_EQ(manual.scale_contact, 1e-6);
}

TEST_F(CaseFile, WindowsLineEndsAndMarksAreAccepted) {
  std::string text = "\xef\xbb\xbf";
  for (const auto &line : good_lines) text += line + "\r\n";
  EXPECT_EQ(read_case(write(text), {}).max_points, 300);
}

TEST_F(CaseFile, OutOverridesTheDirectory) {
  const Case study = read_case(write(Changes{}), "elsewhere/out");
  EXPECT_EQ(study.directory, "elsewhere/out");
  EXPECT_EQ(study.given.at("output.directory"), "--out");
}

TEST_F(CaseFile, FileThatIsNoCaseFile) {
  expect_words(message_of([&] { read_case(folder / "none.toml", {}); }), {"none.toml: ", "no such case file"});
  expect_words(message_of([&] { read_case(folder, {}); }), {folder.string(), "is a folder", "case.toml"});
  std::ofstream(folder / "binary.h5", std::ios::binary) << "\x89HDF\r\n\x1a\n" << std::string(9000, '\0');
  expect_words(message_of([&] { read_case(folder / "binary.h5", {}); }), {"binary.h5: ", "not a text file"});
  expect_words(message_of([&] { read_case(write(""), {}); }), {"case.toml: model is missing"});
}

TEST_F(CaseFile, SyntaxErrors) {
  refused(18, "harmonics 5", {"harmonics 5", "missing key-value separator", "should be `=`"});
  refused(18, "harmonics = five", {"harmonics = five", "unknown value", "quotes"});
  refused(7, "stiffness = .5", {"stiffness = .5", "integer part required"});
  refused(2, "model = \"model.h5", {"model = \"model.h5", "not a valid string"});
  refused(22, "step_tolerance = 1e-6", {"step_tolerance", "already exists", "defined twice"});
  refused(24, "[newton]", {"[newton]", "already exists"});
  refused({{9, "fourier = [0, 0, 1"}}, 10, {"[contact]", "missing array separator"});
}

TEST_F(CaseFile, UnknownKeysAndSections) {
  refused(21, "step_tolerence = 1e-5",
          {"unknown key newton.step_tolerence = 1e-5", "did you mean step_tolerance in [newton]?"});
  refused(27, "omgea = [0.9, 1.3]", {"unknown key continuation.omgea = [0.9, 1.3]", "did you mean omega"});
  refused(21, "colour = 3",
          {"newton.colour", "allowed in [newton]: step_tolerance, residual_tolerance, max_iterations"});
  refused(3, "harmonics = 5", {"unknown key harmonics = 5", "did you mean harmonics in [harmonic_balance]?"});
  refused(5, "model = 2", {"unknown key reduction.model = 2", "did you mean model above the first section?"});
  refused(3, "banana = 5", {"unknown key banana", "allowed above the first section: title, model, reduced"});
  refused(20, "[newtn]", {"unknown section [newtn]", "did you mean [newton]?"});
  refused(20, "[solver]", {"unknown section [solver]", "[harmonic_balance], [newton], [scaling]"});
  refused({{20, "[newtn]"}, {34, "directry = \"out\""}, {5, "mods = 2"}}, 5, {"reduction.mods"}); // the first one
  refused(5, "mode = 2", {"unknown key reduction.mode = 2", "did you mean modes in [reduction]?"});
  refused({{3, "newton = 5"}, {20, ""}, {21, ""}, {22, ""}, {23, ""}}, 3, {"newton is a section", "[newton]"});
  refused(20, "[[newton]]", {"newton is a section"});
  refused({{33, "[stability]\nenable = true\n[output]"}}, 34,
          {"unknown key stability.enable", "did you mean enabled in [stability]?"});
  refused({{1, ""}, {33, "[title]"}, {34, ""}}, 33, {"title = [title]", "must be text in quotes"});
}

TEST_F(CaseFile, MissingKeys) {
  refused({{2, ""}}, 0, {"model is missing", "reduced = \"reduced.h5\""});
  refused({{5, ""}}, 4, {"reduction.modes is missing", "[reduction]"});
  refused({{8, ""}, {9, ""}}, 0, {"excitation.fourier is missing", "fourier = [0, 1]", "under [excitation]"});
  refused({{18, ""}}, 17, {"harmonic_balance.harmonics is missing", "harmonics = 5"});
  refused({{27, ""}}, 26, {"continuation.omega is missing", "omega = [from, to]"});
}

TEST_F(CaseFile, ModelOrReduced) {
  refused({{3, "reduced = \"reduced.h5\""}}, 3, {"reduced = \"reduced.h5\"", "line 2", "keep one"});
  refused({{2, "reduced = \"reduced.h5\""}}, 5, {"reduction.modes = 2", "delete this key"});
  refused(5, "modes = -1", {"reduction.modes = -1", "at least 0"});
}

TEST_F(CaseFile, FilesNamedMustExist) {
  refused(2, "model = \"nowhere.h5\"", {"model = \"nowhere.h5\"", "no file", (folder / "nowhere.h5").string()});
  refused({{2, "reduced = \"nowhere.h5\""}, {5, ""}}, 2, {"reduced = \"nowhere.h5\"", "no file"});
  refused(32, "start = \"nowhere.h5\"", {"continuation.start = \"nowhere.h5\"", "no file"});
  refused(2, "model = \".\"", {"model = \".\"", "is not a file"});
  refused(2, "model = \"\"", {"model = \"\"", "is empty"});
  fs::create_directory(folder / "out");
  std::ofstream(folder / "out" / "results.h5") << "x";
  refused(32, "start = \"out/results.h5\"", {"continuation.start", "overwrite", "output.directory"});
}

TEST_F(CaseFile, WrongTypes) {
  refused(1, "title = 5", {"title = 5", "text in quotes"});
  refused(2, "model = 5", {"model = 5", "text in quotes"});
  refused(7, "stiffness = \"0.05\"", {"damping.stiffness = \"0.05\"", "must be a number", "without quotes"});
  refused(7, "stiffness = true", {"damping.stiffness = true", "must be a number"});
  refused(7, "stiffness = 1979-05-27", {"1979-05-27", "must be a number"});
  refused(23, "max_iterations = 10.0", {"newton.max_iterations = 10.0", "must be a whole number; write 10"});
  refused(23, "max_iterations = 1e3", {"newton.max_iterations = 1e3", "write 1000"});
  refused(23, "max_iterations = 10.5", {"newton.max_iterations = 10.5", "must be a whole number"});
  refused(23, "max_iterations = \"10\"", {"newton.max_iterations = \"10\"", "without quotes"});
  refused(18, "harmonics = nan", {"harmonics = nan", "must be a whole number"});
  refused(29, "adaptive = 1", {"continuation.adaptive = 1", "true or false"});
  refused(9, "fourier = 1", {"excitation.fourier = 1", "list in brackets"});
  refused(9, "fourier = [0, \"x\"]", {"entry 2 of excitation.fourier = \"x\"", "must be a number"});
  refused(34, "directory = 3", {"output.directory = 3", "text in quotes"});
}

TEST_F(CaseFile, NumbersMustBeFinite) {
  refused(7, "stiffness = 1e999", {"stiffness = 1e999", "finite"});
  for (const char *value : {"nan", "inf", "-inf", "+nan"})
    refused(7, std::string("stiffness = ") + value, {std::string("damping.stiffness = ") + value, "finite"});
  refused(27, "omega = [0.9, inf]", {"entry 2 of continuation.omega = inf", "finite"});
  refused(14, "gap = nan", {"contact.gap = nan", "finite"});
  refused(16, "initial = nan", {"preload.initial = nan", "finite"});
  refused(7, "stiffness = 99999999999999999999", {"99999999999999999999", "too many digits"});
}

TEST_F(CaseFile, NumbersOutOfRange) {
  refused(7, "stiffness = -0.1", {"damping.stiffness = -0.1", "must not be negative"});
  refused(7, "mass = -0.1", {"damping.mass = -0.1", "must not be negative"});
  refused(7, "structural = -0.1", {"damping.structural = -0.1", "must not be negative"});
  refused(18, "harmonics = 0", {"harmonic_balance.harmonics = 0", "at least 1"});
  refused(18, "harmonics = 2000000000", {"harmonic_balance.harmonics = 2000000000", "at most"});
  refused(18, "harmonics = 99999999999999999999", {"99999999999999999999"});
  refused(19, "samples = 8", {"harmonic_balance.samples = 8 is too small for harmonics = 5: at least 2*5+1 = 11"});
  refused(19, "samples = 10", {"too small"});
  refused(19, "samples = -3", {"samples = -3", "at least"});
  refused(19, "samples = \"many\"", {"harmonic_balance.samples = \"many\"", "\"exact\", or a number of samples"});
  refused(19, "samples = 0", {"harmonic_balance.samples = 0", "at least 3"});
  refused(19, "samples = 64.0", {"harmonic_balance.samples = 64.0", "write 64"});
  refused(21, "step_tolerance = 0", {"newton.step_tolerance = 0", "greater than 0 and less than 1"});
  refused(21, "step_tolerance = 1.0", {"newton.step_tolerance = 1.0", "less than 1"});
  refused(22, "residual_tolerance = -1e-5", {"newton.residual_tolerance = -1e-5", "greater than 0"});
  refused(23, "max_iterations = 0", {"newton.max_iterations = 0", "at least 1"});
  refused(28, "step = 0.0", {"continuation.step = 0.0", "greater than 0"});
  refused(30, "max_points = 0", {"continuation.max_points = 0", "at least 1"});
}

TEST_F(CaseFile, Excitation) {
  refused(9, "fourier = [0, 0, 0]", {"excitation.fourier = [0, 0, 0]", "nothing would move"});
  refused(9, "fourier = []", {"nothing would move"});
  refused(9, "fourier = [2, 0, 0]", {"excitation.fourier = [2, 0, 0]", "nothing would vibrate", "/preload"});
  refused({{9, "fourier = [0, 0, 1, 0, 0, 2]"}, {18, "harmonics = 2"}}, 9,
          {"the force has harmonic 3", "harmonic_balance.harmonics = 2", "at least 3"});
}

TEST_F(CaseFile, SeveralLoads) {
  const std::string lift = "[[excitation.load]]\npattern = \"lift\"\nfourier = [0, 1]";
  const auto with = [&](const std::string &more) { // from line 9 on: lift is on 9 to 11, more begins on line 12
    return Changes{{8, ""}, {9, lift + "\n" + more}};
  };
  const auto load = [](const std::string &pattern, const std::string &fourier) {
    return "[[excitation.load]]\npattern = \"" + pattern + "\"\nfourier = " + fourier;
  };
  const Case study = read(with(load("force", "[0, 0, 0.3, 0, 1]")));
  ASSERT_EQ(study.loads.size(), 2u);
  EXPECT_EQ(study.loads[0].pattern, "lift");
  EXPECT_EQ(study.loads[1].pattern, "force");
  EXPECT_EQ(study.loads[0].fourier, (std::vector<double>{0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0}));
  EXPECT_EQ(study.loads[1].fourier, (std::vector<double>{0, 0, 0.3, 0, 1, 0, 0, 0, 0, 0, 0}));
  EXPECT_EQ(read({{9, "load = [{pattern = \"a b\", fourier = [0, 1]}]"}}).loads[0].pattern, "a b");
  EXPECT_EQ(read(with(load("still", "[0]"))).loads[1].fourier.size(), 11u); // one of them may rest

#if TOML11_VERSION_MAJOR < 4 // which takes it for one table
  refused(with("[excitation]\nfourier = [0, 1]"), 12, {"excitation", "already exists"});
#endif
  refused({{9, "fourier = [0, 1]\nload = [{pattern = \"lift\", fourier = [1]}]"}}, 10,
          {"excitation.load: excitation.fourier is given as well, in line 9", "keep one of the two"});
  refused({{8, ""}, {9, "[excitation.load]\npattern = \"lift\"\nfourier = [0, 1]"}}, 9,
          {"excitation.load: write [[excitation.load]], in double brackets"});
  refused({{9, "load = \"lift\""}}, 9, {"write [[excitation.load]], in double brackets"});
  refused({{9, "load = []"}}, 9, {"write [[excitation.load]], in double brackets"});
  refused(with(load("lift", "[0, 0, 1]")), 13,
          {"excitation.load.pattern = \"lift\"", "has its course in line 10 already", "add the coefficients"});
  refused(with("[[excitation.load]]\nfourier = [0, 1]"), 12,
          {"excitation.load.pattern is missing", "pattern = \"force\""});
  refused(with("[[excitation.load]]\npattern = \"drag\""), 12, {"excitation.load.fourier is missing", "[0, 1]"});
  refused(with(load("drag", "1")), 14, {"excitation.load.fourier = 1", "list in brackets"});
  refused(with(load("drag", "[0, \"x\"]")), 14, {"entry 2 of excitation.load.fourier = \"x\"", "must be a number"});
  refused(with("[[excitation.load]]\npattern = 3\nfourier = [1]"), 13,
          {"excitation.load.pattern = 3", "text in quotes"});
  refused(with(load("drag", "[0, 1]\nfuorier = [1]")), 15,
          {"unknown key excitation.load.fuorier = [1]", "did you mean fourier in [[excitation.load]]?"});
  refused(with(load("drag", "[0, 1]\nphase = 90")), 15,
          {"unknown key excitation.load.phase = 90", "allowed in [[excitation.load]]: pattern, fourier"});
  refused(with(load("drag", "[0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 7]")), 14,
          {"excitation.load.fourier", "the force has harmonic 6", "harmonic_balance.harmonics = 5", "at least 6"});
  refused({{8, ""}, {9, load("drag", "[0, 0]")}}, 9,
          {"excitation.load: all coefficients are zero", "nothing would move"});
  refused({{8, ""}, {9, load("drag", "[3]")}}, 9, {"excitation.load: is constant alone", "nothing would vibrate"});
  const auto without_pattern = [&](const Changes &changes, const std::vector<std::string> &patterns) {
    return message_of([&] { check_patterns(read(changes), patterns, "model.h5"); });
  };
  expect_words(
      without_pattern(with(load("drag", "[1]")), {"lift", "moment"}),
      {":13: excitation.load.pattern = \"drag\": no such load pattern in model.h5; it has \"lift\", \"moment\""});
  expect_words(
      without_pattern({}, {"lift", "moment"}),
      {":9: excitation.fourier = [0, 0, 1]: is the course of the load pattern \"force\", which model.h5 has not",
       "[[excitation.load]] with one of \"lift\", \"moment\""});
  EXPECT_EQ(without_pattern(with(load("drag", "[1]")), {"drag", "force", "lift"}), "nothing was wrong");
}

TEST_F(CaseFile, Sweep) {
  refused(27, "omega = 1.0", {"continuation.omega = 1.0", "[from, to]"});
  refused(27, "omega = [1.0]", {"continuation.omega = [1.0]", "two numbers"});
  refused(27, "omega = [1.0, 2.0, 3.0]", {"two numbers", "not 3"});
  refused(27, "omega = [0, 1.3]", {"entry 1 of continuation.omega = 0", "greater than 0"});
  refused(27, "omega = [0.9, -1.3]", {"entry 2 of continuation.omega = -1.3", "greater than 0"});
  refused(31, "at = [1.0, 1.4]", {"entry 2 of continuation.at = 1.4", "outside continuation.omega = [0.9, 1.3]"});
  refused(31, "at = [1.1, 1.0]", {"entry 2 of continuation.at = 1.0", "order of the sweep", "1.1"});
  refused(31, "at = [1.1, 1.1]", {"entry 2 of continuation.at", "each once"});
  refused({{31, "at = [\n1.0,\n2.0]"}}, 33, {"entry 2 of continuation.at = 2.0"});
  refused({{27, "omega = [1.3, 0.9]"}}, 31, {"entry 2 of continuation.at = 1.1", "order of the sweep"});
}

TEST_F(CaseFile, FrequenciesInHertz) {
  const Changes hertz = {{27, "omega = [0.1, 0.3]"}, {30, "unit = \"Hz\""}, {31, "at = [0.2]"}};
  const Case study = read(hertz);
  EXPECT_EQ(study.omega_from, 0.1 * (2 * M_PI));
  EXPECT_EQ(study.omega_to, 0.3 * (2 * M_PI));
  EXPECT_EQ(study.at, std::vector<double>{0.2 * (2 * M_PI)});
  EXPECT_EQ(study.frequency_unit.number(study.omega_to), "0.3");
  EXPECT_EQ(study.frequency_unit.text(study.omega_to, 6), "0.3 Hz = 1.88496 rad/s");
  std::ostringstream out;
  describe(out, study, contact_points(study.contact, {}, 2), units_of("SI"));
  EXPECT_NE(out.str().find("[0.1, 0.3]"), std::string::npos) << out.str();
  EXPECT_NE(out.str().find("[0.628319, 1.884956]"), std::string::npos) << out.str();
  Changes outside = hertz;
  outside.back() = {31, "at = [0.4]"};
  refused(outside, 31, {"entry 1 of continuation.at = 0.4", "outside continuation.omega = [0.1, 0.3] Hz"});
  outside.back() = {31, "at = [0.2, 0.15]"};
  refused(outside, 31, {"entry 2 of continuation.at", "the entry before is 0.2"});
  refused(30, "unit = \"rpm\"", {"continuation.unit = \"rpm\"", "\"rad/s\" or \"Hz\""});
  refused(30, "unit = 1", {"continuation.unit = 1", "\"rad/s\" or \"Hz\""});
  EXPECT_EQ(read({{30, "unit = \"rad/s\""}}).omega_to, 1.3);
}

TEST_F(CaseFile, WatchAndStops) {
  const Case plain = read();
  EXPECT_EQ(watched_dof(plain, 2, 3), -1);
  EXPECT_EQ(plain.stop_after_peaks, 0);
  EXPECT_EQ(plain.stop_at_amplitude, 0);
  const auto watching = [&](const std::string &name) {
    return read({{30, "watch = \"" + name + "\"\nstop_after_peaks = 2\nstop_at_amplitude = 1e-3"}});
  };
  EXPECT_EQ(watched_dof(watching("a2"), 2, 3), 1);
  EXPECT_EQ(watched_dof(watching("x1.t1"), 2, 3), 2);
  EXPECT_EQ(watched_dof(watching("x3.n"), 2, 3), 10);
  EXPECT_EQ(watched_dof(watching("x3.t2"), 0, 3), 7);
  EXPECT_EQ(watching("a2").stop_after_peaks, 2);
  EXPECT_EQ(watching("a2").stop_at_amplitude, 1e-3);
  expect_words(message_of([&] { watched_dof(watching("a3"), 2, 3); }),
               {"case.toml:30: continuation.watch = \"a3\"", "has 2 modes"});
  expect_words(message_of([&] { watched_dof(watching("x4.n"), 2, 3); }), {"watch = \"x4.n\"", "has 3 contact points"});
  for (const char *name : {"x1", "x1.t3", "x0.n", "a0", "a", "tip", "x1.n ", "a1x1.n", "x99999999999.n"})
    refused(30, std::string("watch = \"") + name + "\"",
            {std::string("continuation.watch = \"") + name, "\"x1.t1\"", "\"a1\""});
  refused(30, "watch = 1", {"continuation.watch = 1", "text in quotes"});
  refused(30, "stop_after_peaks = 0", {"continuation.stop_after_peaks = 0", "at least 1"});
  refused(30, "stop_after_peaks = 1.5", {"continuation.stop_after_peaks = 1.5", "whole number"});
  refused(30, "stop_at_amplitude = 0", {"continuation.stop_at_amplitude = 0", "greater than 0"});
  refused(30, "stop_at_amplitude = \"big\"", {"continuation.stop_at_amplitude", "must be a number"});
}

TEST_F(CaseFile, StabilityIsForSmallModels) {
  const auto settled = [&](const std::string &lines, int dofs) { // 5 harmonics
    Case study = read({{33, lines + "[output]"}});
    settle_stability(study, dofs);
    return study.stability.value();
  };
  EXPECT_TRUE(settled("", 13));
  EXPECT_FALSE(settled("", 14));
  EXPECT_FALSE(settled("[stability]\nenabled = false\n", 3));
  EXPECT_TRUE(settled("[stability]\nenabled = true\n", 3000));
  refused({{33, "[stability]\nenabled = \"yes\"\n[output]"}}, 34, {"stability.enabled = \"yes\"", "true or false"});
}

TEST_F(CaseFile, HystereticDampingHasNoMotionInTime) {
  Case study = read({{7, "structural = 0.02"}});
  settle_stability(study, 3); // a small model
  EXPECT_FALSE(study.stability.value());
  EXPECT_FALSE(read({{7, "structural = 0.02"}, {33, "[stability]\nenabled = false\n[output]"}}).stability.value());
  refused({{7, "structural = 0.02"}, {33, "[stability]\nenabled = true\n[output]"}}, 34,
          {"stability.enabled = true", "damping.structural = 0.02", "case.toml:7", "write false"});
  study = read({{7, "ratios = [[2, 0.01]]"}});
  settle_stability(study, 3);
  EXPECT_TRUE(study.stability.value());
  ASSERT_EQ(study.damping.ratios.size(), 1u);
  EXPECT_EQ(study.damping.ratios[0].mode, 2);
  EXPECT_FALSE(study.damping.of_fixed);
  study = read({{7, "mass = 0.02"}});
  settle_stability(study, 3);
  EXPECT_TRUE(study.stability.value());
}

TEST_F(CaseFile, DampingOfTheModelAndOfContacts) {
  Case study = read({{7, "matrix = true\nratios = [[2, 0.01]]\nof = \"fixed\""}});
  EXPECT_TRUE(study.damping.matrix);
  EXPECT_TRUE(study.damping.of_fixed);
  EXPECT_FALSE(study.damping.contact);
  EXPECT_NO_THROW(check_damping(study, 2, 1, true));
  for (const auto &[modes, has, words] : {std::tuple(2, false, "has no /C"), {1, true, "1 fixed-interface modes"}}) {
    try {
      check_damping(study, modes, 1, has);
      ADD_FAILURE() << words;
    } catch (const InputError &error) {
      EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
    }
  }
  EXPECT_TRUE(read({{7, "stiffness = 0.05\ncontact = true"}}).damping.contact);
  refused({{7, "mass = 0.05\ncontact = true"}}, 8, {"damping.contact = true", "damping.stiffness"});
  refused(7, "matrix = 1", {"damping.matrix = 1", "true or false"});
  refused(7, "of = \"open\"", {"damping.of = \"open\"", "\"stuck\" or \"fixed\""});
}

TEST_F(CaseFile, RestartKnowsAnotherProblem) {
  const auto points = [](const Case &study) { return contact_points(study.contact, {}, 2); };
  const auto problem = [&](Case study) {
    settle_stability(study, 8);
    return problem_of(study, points(study));
  };
  const std::string before = problem(read());
  const auto same = [&](const Changes &changes) { return problem(read(changes)) == before; };
  EXPECT_TRUE(same({{1, "title = \"another\""}, {3, "# words"}, {7, "stiffness = 5e-2"}})); // only written differently
  EXPECT_TRUE(same({{9, "fourier = [0, 0, 1.0, 0]"}, {12, "tangential_stiffness = [[1, 2], [1, 2]]"}}));
  EXPECT_TRUE(same({{27, "omega = [0.9, 1.5]"}, {30, "max_points = 9"}, {23, "max_iterations = 7"}, {34, ""}}));
  EXPECT_TRUE(same({{30, "stop_after_peaks = 1\nstop_at_amplitude = 2"}, {31, ""}, {32, ""}}));
  EXPECT_TRUE(same({{27, "omega = [0.14323944878270581, 0.25]"}, {30, "unit = \"Hz\""}, {31, ""}})); // 0.9 rad/s
  const Changes others = {{7, "stiffness = 0.06"},
                          {7, "stiffness = 0.05\nmass = 0.01"},
                          {7, "stiffness = 0.05\nstructural = 0.01"},
                          {7, "stiffness = 0.05\nratios = [[1, 0.01]]"},
                          {9, "fourier = [0, 0, 2]"},
                          {11, "normal_stiffness = 1.1"},
                          {13, "friction = 0.3"},
                          {14, "gap = -3.4"},
                          {18, "harmonics = 6"},
                          {19, "samples = 65"},
                          {21, "step_tolerance = 1e-6"},
                          {25, "kind = \"auto\""},
                          {27, "omega = [0.8, 1.3]"},
                          {28, "step = 0.06"},
                          {29, "adaptive = true"},
                          {30, "watch = \"a1\""},
                          {5, "modes = 3"},
                          {33, "[stability]\nenabled = false\n[output]"}};
  for (const auto &change : others) EXPECT_FALSE(same({change})) << change.second;
  EXPECT_FALSE(same({{27, "omega = [1.3, 0.9]"}, {31, ""}}));

  Case study = read({{18, "harmonics = 7"}});
  settle_stability(study, 8);
  expect_words(message_of([&] { refuse_other_problem(study, points(study), before); }),
               {"case.toml:18: harmonic_balance.harmonics = 7: this run began with 5", "without --restart"});
  expect_words(message_of([&] { refuse_other_problem(study, points(study), "written by another version"); }),
               {"case.toml", "this run began with another version"});
}

TEST_F(CaseFile, RestartKnowsHowFarARunGoes) {
  const std::string before = limits_of(read());
  for (const auto &change : Changes{{27, "omega = [0.9, 1.4]"},
                                    {30, "max_points = 301"},
                                    {30, "stop_after_peaks = 1"},
                                    {30, "stop_at_amplitude = 1"},
                                    {23, "max_iterations = 51"}})
    EXPECT_NE(limits_of(read({change})), before) << change.second;
  EXPECT_EQ(limits_of(read({{7, "stiffness = 0.06"}, {1, ""}})), before);
}

TEST_F(CaseFile, Scaling) {
  refused(25, "kind = \"automatic\"", {"scaling.kind = \"automatic\"", "\"auto\", \"none\" or \"manual\""});
  refused({{25, "kind = \"manual\"\nfrequency = 1.0\ncontact = 1.0"}}, 24, {"scaling.modal is missing", "manual"});
  refused({{25, "kind = \"manual\"\nfrequency = 1.0\nmodal = 0\ncontact = 1.0"}}, 27,
          {"scaling.modal = 0", "greater than 0"});
  refused({{25, "kind = \"auto\"\nfrequency = 1.0"}}, 26, {"scaling.frequency = 1.0", "only with kind = \"manual\""});
  refused({{25, "modal = 1.0"}}, 25, {"scaling.modal = 1.0", "only with kind"});
}

TEST_F(CaseFile, ContactValues) {
  refused(11, "normal_stiffness = 0", {"contact.normal_stiffness = 0", "greater than 0"});
  refused(11, "normal_stiffness = [1.0, -2.0, 3.0]",
          {"contact.normal_stiffness = -2 at contact point 1 (counted from 0): ", "greater than 0"});
  refused(11, "normal_stiffness = []", {"contact.normal_stiffness = []", "is empty"});
  refused(11, "normal_stiffness = [[1.0, 2.0]]", {"contact.normal_stiffness = [1.0, 2.0]", "must be a number"});
  refused(12, "tangential_stiffness = [1.0, -2.0]", {"contact.tangential_stiffness = -2 along t2: ", "greater than 0"});
  refused(13, "friction = -0.1", {"contact.friction = -0.1", "must not be negative"});
  refused(13, "friction = [[0.1, 0.1], [0.1, -0.2]]",
          {"friction = -0.2 at contact point 1 (counted from 0) along t2: ", "negative"});
  refused(13, "friction = [[0.1, 0.1], [0.1]]", {"entry 2 of contact.friction = [0.1]", "pair [t1, t2]"});
  refused(13, "friction = [[0.1, 0.1], 0.1]", {"entry 2 of contact.friction = 0.1", "list in brackets"});
  refused(13, "friction = \"rough\"", {"contact.friction = \"rough\"", "must be a number"});
}

TEST_F(CaseFile, ContactLaw) {
  using Words = std::vector<Law>;
  EXPECT_EQ(read({{14, "law = \"cone\""}, {13, "friction = 0.3"}, {19, ""}}).contact.law.values, Words{Law::cone});
  const Case mixed = read({{14, "law = [\"bilateral\", \"coulomb\", \"unilateral\"]"}});
  EXPECT_EQ(mixed.contact.law.values, (Words{Law::bilateral, Law::coulomb, Law::unilateral}));
  const auto points = contact_points(mixed.contact, {}, 3);
  EXPECT_EQ(points[1].law, Law::coulomb);
  EXPECT_EQ(points[1].mu, (std::array<double, 2>{0.3, 0.4}));
  EXPECT_EQ(points[2].law, Law::unilateral);
  EXPECT_EQ(points[2].mu, (std::array<double, 2>{0, 0})); // what it does not know is cleared
  EXPECT_EQ(points[2].kt, (std::array<double, 2>{0, 0}));
  EXPECT_EQ(points[2].kn, 1);

  const std::vector<std::string> all = {"must be \"coulomb\", \"cone\", \"unilateral\" or \"bilateral\""};
  refused(14, "law = \"Coulomb\"", {"contact.law = \"Coulomb\": ", all[0]});
  refused(14, "law = 3", {"contact.law = 3: ", all[0]});
  refused(14, "law = [\"cone\", \"glue\"]", {"entry 2 of contact.law = \"glue\": ", all[0]});
  refused(14, "law = []", {"contact.law = []", "is empty"});
  expect_words(message_of([&] { contact_points(mixed.contact, {}, 4); }),
               {"case.toml:14: contact.law: 3 words found", "N_x = 4", "one word", "4 words"});
  const auto one = read({{14, "law = [\"coulomb\"]"}}).contact;
  expect_words(message_of([&] { contact_points(one, {}, 2); }), {"1 words found", "N_x = 2"});
}

TEST_F(CaseFile, FrictionWhereNoPointHasAny) {
  const Changes bare = {{12, ""}, {13, ""}, {14, "law = \"unilateral\""}};
  const auto points = contact_points(read(bare).contact, {}, 2);
  EXPECT_EQ(points[1].law, Law::unilateral);
  EXPECT_EQ(points[1].kn, 1);
  refused({{14, "law = \"bilateral\""}}, 12, {"contact.tangential_stiffness = [1.0, 2.0]", "no effect", "delete"});
  refused({{12, ""}, {14, "law = [\"bilateral\", \"unilateral\"]"}}, 13,
          {"contact.friction = [0.3, 0.4]", "no effect"});
  ContactSettings model; // a model file may serve other cases as well
  model.friction = ContactSetting{{-1, 2, 3}, false, "model.h5: /contact/friction"};
  EXPECT_EQ(contact_points(read(bare).contact, model, 2)[0].mu, (std::array<double, 2>{0, 0}));
  const auto needed = read({{13, ""}, {14, "law = [\"unilateral\", \"coulomb\"]"}}).contact;
  expect_words(message_of([&] { contact_points(needed, {}, 2); }), {"contact.friction is missing"});
}

TEST_F(CaseFile, Cone) {
  const Changes changes = {{13, "friction = [[0.3, 0.4], [0.5, 0.5]]"}};
  const auto message = [&](const std::string &law) {
    auto all = changes;
    all.push_back({14, "law = " + law});
    return message_of([&] { contact_points(read(all).contact, {}, 2); });
  };
  EXPECT_EQ(message("[\"coulomb\", \"cone\"]"), "nothing was wrong");
  expect_words(message("[\"cone\", \"coulomb\"]"), {"case.toml:13: contact.friction = [0.3, 0.4] at contact point 0",
                                                    "counted from 0", "\"cone\"", "the same number for t1 and t2"});
  ContactSettings model;
  model.friction = ContactSetting{{0.1, 0.2}, true, "model.h5: /contact/friction"};
  const auto settings = read({{13, ""}, {14, "law = \"cone\""}}).contact;
  expect_words(message_of([&] { contact_points(settings, model, 2); }),
               {"model.h5: /contact/friction = [0.1, 0.2] at contact point 0"});

  EXPECT_EQ(read({{14, "law = \"cone\""}}).samples, 64);
  EXPECT_EQ(read({{14, "law = \"cone\""}, {19, ""}}).samples, 0); // all but the cone
  EXPECT_EQ(read({{14, "law = [\"coulomb\", \"cone\"]"}, {19, "samples = \"exact\""}}).samples, exactly);
}

TEST_F(CaseFile, ContactPointsFromTheCase) {
  const auto points = contact_points(read().contact, {}, 3);
  ASSERT_EQ(points.size(), 3u);
  EXPECT_EQ(points[2].kn, 1);
  EXPECT_EQ(points[2].kt, (std::array<double, 2>{1, 2}));
  EXPECT_EQ(points[2].mu, (std::array<double, 2>{0.3, 0.4}));
  EXPECT_EQ(points[2].gap, -3.5);

  const auto varied = contact_points(read({{11, "normal_stiffness = [5, 6]"},
                                           {12, "tangential_stiffness = [[1, 2], [3, 4]]"},
                                           {13, "friction = 0.5"},
                                           {14, ""}})
                                         .contact,
                                     {}, 2);
  EXPECT_EQ(varied[1].kn, 6);
  EXPECT_EQ(varied[1].kt, (std::array<double, 2>{3, 4}));
  EXPECT_EQ(varied[0].mu, (std::array<double, 2>{0.5, 0.5}));
  EXPECT_EQ(varied[0].gap, 0);

  // Two plain numbers are a pair even for two points; three are one per point, both directions alike.
  EXPECT_EQ(contact_points(read().contact, {}, 2)[0].kt, (std::array<double, 2>{1, 2}));
  EXPECT_EQ(contact_points(read({{13, "friction = [0.1, 0.2, 0.3]"}}).contact, {}, 3)[1].mu,
            (std::array<double, 2>{0.2, 0.2}));
}

TEST_F(CaseFile, StiffnessPerAreaIsOfTheAreaOfEachPoint) {
  ContactSettings model;
  model.area = {2.0, 0.5};
  model.normal_stiffness = ContactSetting{{7}, false, "model.h5: /contact/normal_stiffness"};
  const auto settings = read({{11, "normal_stiffness_per_area = 10"}, {12, "tangential_stiffness_per_area = [4, 6]"}});
  const auto points = contact_points(settings.contact, model, 2);
  EXPECT_EQ(points[0].kn, 20);
  EXPECT_EQ(points[1].kn, 5);
  EXPECT_EQ(points[0].kt, (std::array<double, 2>{8, 12}));
  EXPECT_EQ(points[1].kt, (std::array<double, 2>{2, 3}));

  const auto message = [&](const std::vector<double> &area) {
    model.area = area;
    return message_of([&] { contact_points(settings.contact, model, 2); });
  };
  expect_words(message({}), {"case.toml:11: contact.normal_stiffness_per_area", "the area of the contact points",
                             "no /contact/area", "[N/m]"});
  expect_words(message({2.0, 0.0}), {"the area of contact point 1 (counted from 0) is not known"});
  refused(11, "normal_stiffness_per_area = 1\nnormal_stiffness = 1",
          {"contact.normal_stiffness_per_area", "contact.normal_stiffness both say the same"});
  refused(11, "normal_stiffness_per_area = -1", {"contact.normal_stiffness_per_area = -1", "greater than 0"});
  refused(13, "friction_per_area = 1", {"friction_per_area"});
}

TEST_F(CaseFile, ContactPointsOfWrongLength) {
  const auto message = [&](size_t line, const std::string &text, int n) {
    const auto settings = read({{line, text}}).contact;
    return message_of([&] { contact_points(settings, {}, n); });
  };
  expect_words(message(11, "normal_stiffness = [1, 2, 3]", 4),
               {"case.toml:11: contact.normal_stiffness: 3 values found", "N_x = 4"});
  expect_words(message(11, "normal_stiffness = [1.0]", 4), {"1 values found", "N_x = 4"});
  expect_words(message(13, "friction = [0.1, 0.2, 0.3]", 4), {"case.toml:13: contact.friction: 3 values", "N_x = 4"});
  expect_words(message(13, "friction = [[0.1, 0.2]]", 4), {"1 pairs found", "4 pairs"});
}

TEST_F(CaseFile, ContactPointsFromTheModel) {
  ContactSettings model;
  model.normal_stiffness = ContactSetting{{7, 8}, false, "model.h5: /contact/normal_stiffness"};
  model.friction = ContactSetting{{0.1, 0.2, 0.3, 0.4}, true, "model.h5: /contact/friction"};
  model.gap = ContactSetting{{1, 2}, false, "model.h5: /contact/gap"};
  const auto points = contact_points(read({{11, ""}, {13, ""}}).contact, model, 2);
  EXPECT_EQ(points[1].kn, 8);
  EXPECT_EQ(points[1].mu, (std::array<double, 2>{0.3, 0.4}));
  EXPECT_EQ(points[1].gap, -3.5); // the case file wins

  const auto settings = read({{12, ""}, {14, ""}}).contact;
  expect_words(
      message_of([&] { contact_points(settings, model, 2); }),
      {"case.toml: contact.tangential_stiffness is missing", "tangential_stiffness = [1e6, 1e6]", "[contact]"});
  const auto bare = read({{11, ""}, {13, ""}}).contact;
  model.normal_stiffness->values[1] = -8;
  expect_words(message_of([&] { contact_points(bare, model, 2); }),
               {"model.h5: /contact/normal_stiffness = -8 at contact point 1 (counted from 0): ", "greater than 0"});
  model.normal_stiffness->values = {1, 2, 3};
  expect_words(message_of([&] { contact_points(bare, model, 2); }), {"/contact/normal_stiffness: 3 values", "N_x = 2"});
  model.normal_stiffness->values = {1, std::nan("")};
  expect_words(message_of([&] { contact_points(bare, model, 2); }), {"/contact/normal_stiffness = nan", "finite"});
}

TEST_F(CaseFile, InitialPreload) {
  EXPECT_EQ(initial_preload(read(), 2), std::vector<double>(6, 1e-5));
  EXPECT_EQ(initial_preload(read({{16, "initial = [1, 2, 3]"}}), 1), (std::vector<double>{1, 2, 3}));
  const Case study = read({{16, "initial = [1, 2, 3]"}});
  expect_words(message_of([&] { initial_preload(study, 2); }),
               {"case.toml:16: preload.initial: 3 values found", "N_x = 2", "6 in all"});
  refused(16, "initial = [1, 2]", {"preload.initial = [1, 2]", "2 values", "3 per contact point"});
  refused(16, "initial = [[1, 2, 3]]", {"entry 1 of preload.initial = [1, 2, 3]", "must be a number"});
}

TEST_F(CaseFile, DescriptionNamesValueUnitAndOrigin) {
  const Case study = read({{12, "tangential_stiffness = [[1, 2], [3, 4]]"}, {13, ""}, {14, ""}, {21, ""}, {19, ""}});
  ContactSettings model;
  model.friction = ContactSetting{{0.25}, false, "model.h5: /contact/friction"};
  std::ostringstream out;
  describe(out, study, contact_points(study.contact, model, 2), units_of("SI"));
  const auto line_of = [&](const std::string &key) {
    std::istringstream lines(out.str());
    for (std::string line; std::getline(lines, line);)
      if (line.rfind(key + " ", 0) == 0) return line;
    return "no line for " + key;
  };
  expect_words(line_of("title"), {"test", "given"});
  expect_words(line_of("damping.stiffness"), {"0.05", "[s]", "given"});
  expect_words(line_of("damping.mass"), {" 0 ", "[1/s]", "default"});
  expect_words(line_of("damping.structural"), {" 0 ", "[-]", "default"});
  expect_words(line_of("excitation.fourier"), {"[0, 0, 1] "});
  expect_words(line_of("contact.normal_stiffness"), {" 1 ", "[N/m]", "given"});
  expect_words(line_of("contact.tangential_stiffness"), {"1 .. 4", "[N/m]", "given"});
  expect_words(line_of("contact.friction"), {"0.25", "[-]", "model file"});
  expect_words(line_of("contact.gap"), {" 0 ", "[m]", "default"});
  expect_words(line_of("contact.law"), {"coulomb", "default"});
  expect_words(line_of("harmonic_balance.samples"), {" exact ", "default"});
  expect_words(line_of("newton.step_tolerance"), {"1e-08", "[-]", "default"});
  expect_words(line_of("continuation.omega"), {"[0.9, 1.3]", "[rad/s]", "given"});
  expect_words(line_of(" "), {"[0.143239, 0.206901]", "[Hz]"});
  expect_words(line_of("continuation.watch"), {"what moves most", "default"});
  expect_words(line_of("continuation.stop_after_peaks"), {"never", "default"});
  expect_words(line_of("continuation.stop_at_amplitude"), {"never", "[m]", "default"});
  expect_words(line_of("stability.enabled"), {"true for small models", "default"});
  expect_words(line_of("output.directory"), {"out", "given"});
  EXPECT_EQ(out.str().find("scaling.modal"), std::string::npos); // no meaning here
  EXPECT_EQ(out.str().find("reduced"), std::string::npos);
}

TEST_F(CaseFile, DescriptionOfTheLaws) {
  const auto lines = [&](const Changes &changes) {
    const Case study = read(changes);
    std::ostringstream out;
    describe(out, study, contact_points(study.contact, {}, 3), units_of("SI"));
    return out.str();
  };
  const Changes mixed = {
      {13, "friction = 0.3"}, {14, "law = [\"cone\", \"bilateral\", \"cone\"]"}, {18, "harmonics = 10"}};
  auto text = lines(mixed);
  for (const char *words : {"cone (2), bilateral (1)", "contact.friction ", " 64 ", " 1 .. 2 "})
    EXPECT_NE(text.find(words), std::string::npos) << text << words;
  auto left_out = mixed;
  left_out.push_back({19, ""});
  EXPECT_NE(lines(left_out).find(" exact; cone: 512 "), std::string::npos) << lines(left_out);
  left_out.push_back({18, "harmonics = 3"});
  EXPECT_NE(lines(left_out).find(" exact; cone: 256 "), std::string::npos) << lines(left_out);
  text = lines({{12, ""}, {13, ""}, {14, "law = \"unilateral\""}});
  EXPECT_NE(text.find(" unilateral "), std::string::npos) << text;
  for (const char *key : {"contact.friction", "contact.tangential_stiffness"})
    EXPECT_EQ(text.find(key), std::string::npos) << text;
}

TEST_F(CaseFile, TextThatTheParserWouldNotSurvive) {
  refused(1, "title = 'no\xD2'", {"0xD2", "UTF-8"});
  refused(9, "fourier = [0, 1] # \xC0\xAF", {"0xC0", "UTF-8"});
  refused(9, "fourier = " + std::string(90000, '['), {"levels"});
  refused(9, "fourier = " + std::string(33, '[') + std::string(33, ']'), {"more than 32 levels"});
  refused(1, "title = {a" + std::string(40, '{'), {"levels"});
  std::string dotted = "a", keys, numbers = "0";
  for (int i = 0; i < 45000; ++i) dotted += ".a", keys += "k" + std::to_string(i) + " = 1\n", numbers += ", 0";
  refused(1, dotted + " = 1", {"levels"});
  refused(1, "[" + dotted + "]", {"levels"});
  expect_words(message_of([&] { read({{1, keys}}); }), {"case.toml:1001: ", "more than 1000 keys"});
  refused(9, "fourier = [" + numbers + "]", {"100000 characters", "several lines"});
}

TEST_F(CaseFile, ScreeningPassesOverStringsAndComments) {
  const std::string brackets(40, '['), dots(40, '.');
  const auto title = [&](const std::string &text) { return read({{1, "title = " + text}}).title; };
  EXPECT_EQ(title("\"" + brackets + "\\\" " + dots + "\" # " + brackets), brackets + "\" " + dots);
  EXPECT_EQ(title("'" + brackets + "\\'"), brackets + "\\");
  EXPECT_EQ(title("\"\"\"\n\"\" " + brackets + "\n\"\"\"\"\" # '"), "\"\" " + brackets + "\n\"\"");
  EXPECT_EQ(title("\'\'\'" + brackets + "\n\'\'\'\'"), brackets + "\n'");
  EXPECT_EQ(title("\"\u00e9\u20ac\U0001F600\""), "\u00e9\u20ac\U0001F600");
  std::string pairs = "[0.5, 0.25]", gaps = "-3.5";
  for (int i = 1; i < 5000; ++i) pairs += ", [0.5, 0.25]", gaps += ", -3.5";
  const Case study = read({{13, "friction = [" + pairs + "]"}, {14, "gap = [" + gaps + "]"}});
  EXPECT_EQ(contact_points(study.contact, {}, 5000)[4999].mu[1], 0.25);
}

TEST_F(CaseFile, FewerLawsThanPointsAreNoMatterOfTheForecast) {
  const Case study = read({{14, "law = [\"coulomb\", \"bilateral\"]"}});
  EXPECT_GT(forecast(ReducedHeader{2, 3, {}}, study).unknowns, 0);
  expect_words(message_of([&] { contact_points(study.contact, {}, 3); }), {"case.toml:14", "2 words", "N_x = 3"});
}

TEST_F(CaseFile, OutputFolderIsMadeAndTried) {
  prepare_output(read({{34, "directory = \"new/er\""}}));
  EXPECT_TRUE(fs::is_directory(folder / "new" / "er"));
  EXPECT_TRUE(fs::is_empty(folder / "new" / "er"));
  std::ofstream(folder / "new" / "er" / "results.h5") << "old";
  prepare_output(read({{34, "directory = \"new/er\""}}));
  EXPECT_EQ(fs::file_size(folder / "new" / "er" / "results.h5"), 3u);
}

TEST_F(CaseFile, OutputFolderThatCannotBe) {
  const Case below_file = read({{34, "directory = \"model.h5/out\""}});
  expect_words(message_of([&] { prepare_output(below_file); }),
               {"case.toml:34: output.directory = ", "model.h5/out", "cannot be made"});
  const Case is_file = read({{34, "directory = \"model.h5\""}});
  expect_words(message_of([&] { prepare_output(is_file); }), {"case.toml:34", "model.h5"});
  fs::create_directories(folder / "out" / "results.h5");
  const Case taken = read();
  expect_words(message_of([&] { prepare_output(taken); }), {"case.toml:34", "results.h5", "is not a file"});
  const Case outside = read_case(folder / "case.toml", folder / "model.h5" / "out");
  expect_words(message_of([&] { prepare_output(outside); }), {"--out", "model.h5/out"});
}

} // namespace
} // namespace dovetail
