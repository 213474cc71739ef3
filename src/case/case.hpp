#pragma once
// case.toml as one immutable value, checked; every error text about the user's input file starts here.
#include <algorithm>
#include <array>
#include <filesystem>
#include <iosfwd>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "case/curve_range.hpp"
#include "case/damping.hpp"
#include "case/travelling_wave.hpp"
#include "contact/contact_point.hpp"
#include "recovery/strategies.hpp"
#include "support/units.hpp"

namespace dovetail {

/// One contact parameter as written: a number, one per point, or (tangential ones) a pair, or a pair per
/// point.
struct ContactSetting {
  std::vector<double> values; ///< 1, N_x, 2 or 2 N_x numbers (pairs contiguous)
  bool pairs = false;         ///< values are [t1, t2] pairs
  std::string where;          ///< "file.toml:12: contact.friction" or "model.h5: /contact/friction", for messages
  bool per_point = false;     ///< written as a list with one entry per point, even if that list is short
  bool per_area = false;      ///< a stiffness per area [N/m^3], of the area that belongs to each point
};

/// The contact law as written: one word, or one per point.
struct LawSetting {
  std::vector<Law> values = {Law::coulomb};
  bool per_point = false;
  std::string where; ///< "file.toml:10: contact.law", for messages

  bool any(bool (*wanted)(Law)) const { return std::any_of(values.begin(), values.end(), wanted); }
};

struct ContactSettings {
  LawSetting law; ///< in the case file only
  std::optional<ContactSetting> normal_stiffness, tangential_stiffness, friction, gap;
  std::string file;                ///< where a missing one is to be added, for messages
  std::vector<std::string> joints; ///< names, from a model file
  std::vector<long> joint;         ///< (N_x) number of the joint of each point, from 0; or empty
  std::vector<double> area;        ///< (N_x) of each point, from a model or reduced file; 0 or empty: not known [m^2]
};

/// Name of the load pattern in the dataset /force of a model.
constexpr const char *force_pattern = "force";

/// One pattern of forces and its course over the period: [excitation] fourier, or an entry of [[excitation.load]].
struct LoadCourse {
  std::string pattern = force_pattern;
  std::vector<double> fourier = {0, 1}; ///< f(t) as [a0, a1, b1, ...], padded with zeros to 2H+1
  std::string where;                    ///< what names the pattern, with its place, for messages
};

/// Whose motion is to be recovered later: [output] motion.
struct MotionWish {
  bool given = false, all = false; ///< not given: all while that is little
  std::vector<std::string> sets;   ///< of nodes, in the model file
  std::vector<long> nodes;         ///< rows of /mesh/nodes
  std::string where;               ///< place in the case file, for messages
};

/// The unknown or node whose amplitude is followed, as written: [continuation] watch.
struct Watch {
  std::string name;   ///< "a1", "x3.n", "tip.y"; empty: the contact dof that moves most
  int number = 0;     ///< of the mode or contact point, from 1
  int direction = -1; ///< 0, 1, 2 for t1, t2, n, or of a node for x, y, z; -1: a mode
  std::string node;   ///< a node set, or the row of a node, in the model file; empty: an unknown
  std::string where;  ///< place in the case file, for messages
};

/// What is called a peak: the maximum of the amplitude, or where the motion is a quarter of a period behind the load.
enum class PeakKind { amplitude, phase };

/// A sweep over another parameter than the frequency: [path].
struct Path {
  const PathParameter *parameter = nullptr;
  double from = 0, to = 0;      ///< factors, or an offset of the gap [m]
  std::optional<PeakKind> peak; ///< what is followed; not given: the motion at one frequency
  std::string joint;            ///< whose contact points it is of, by name; empty: see points
  std::vector<int> points;      ///< or those, from 1; empty: all
  std::vector<bool> varied;     ///< (N_x) which that is, once the model is known; empty: all
};

/// A nonlinear mode in place of a sweep: [mode].
struct ModeWish {
  int number = 0;          ///< of the stuck structure at the preload state, from 1; 0: the one next to
  double near = 0;         ///< that frequency [rad/s]
  double from = 0, to = 0; ///< modal amplitude [m kg^1/2]
  double to_force = 0;     ///< or until this multiple of the load; 0: not asked for
};

/// How the harmonic balance is solved: [harmonic_balance] solver.
enum class SolverKind { modal, assembled };

enum class ScalingKind { automatic, none, manual };

struct Case {
  std::filesystem::path file; ///< case.toml as given
  std::string text;           ///< its whole content, kept with the results
  std::string title;
  std::filesystem::path model;   ///< full model, empty when `reduced` is given
  std::filesystem::path reduced; ///< reduced model used as it stands, or empty

  int modes = 0;                   ///< N_a (only with `model`)
  bool residuals = false;          ///< some of the modes made for the loads, not eigenmodes
  bool modes_by_tolerance = false; ///< N_a is not given: as many as `tolerance` wants
  int interior_modes = 0;          ///< of a cyclic sector, that all indices share; 0: by N_a
  bool exact_modes = false;        ///< of a cyclic sector: whatever the interior ones
  bool check_modes = false;        ///< count the modes below the last one
  double memory = 0;               ///< what the reduction may take on one machine [GiB]; 0: all that is free
  Damping damping;
  std::string ratios_where;                  ///< place of damping.ratios in the file, for messages
  std::vector<LoadCourse> loads = {{}};      ///< each of another pattern
  std::optional<int> engine_order;           ///< of the load on a cyclic model
  ContactSettings contact;                   ///< as written here; a model file may supply the rest
  std::vector<double> preload_initial = {0}; ///< x_p0: one number, or 3 N_x [m]
  std::string preload_initial_where;         ///< place in the file, for messages about its length

  int harmonics = 0; ///< H >= 1
  int samples = 0;   ///< N >= 2H+1; 0: exact, no sampling
  SolverKind solver = SolverKind::modal;

  double step_tolerance = 1e-8;     ///< eps_x, relative
  double residual_tolerance = 1e-8; ///< eps_f, in the scaled variables
  int max_iterations = 20;

  ScalingKind scaling = ScalingKind::automatic;
  double scale_frequency = 0, scale_modal = 0, scale_contact = 0; ///< w0, alpha, beta when manual

  Units units;                         ///< of the model, once it is read
  FrequencyUnit frequency_unit;        ///< of the case file
  double omega_from = 0, omega_to = 0; ///< [rad/s]; equal: one point, or the frequency of a path; where peaks are
                                       ///< followed, the first one lies between
  std::optional<Path> path;
  std::optional<ModeWish> mode;
  double step = 0.02; ///< first arc length; of a fixed one in the scaled variables
  bool adaptive = true;
  int max_points = 20000;
  std::vector<double> at;      ///< values of the parameter wanted exactly, in order of the sweep
  std::filesystem::path start; ///< results file to begin from, or empty
  Watch watch;
  bool sensitivity = false;     ///< of its peaks, by all contact parameters
  int stop_after_peaks = 0;     ///< 0: never
  double stop_at_amplitude = 0; ///< of the watched unknown [m]; 0: never

  std::optional<bool> stability; ///< judge every point; not given: settle_stability() decides

  Strategies strategies = Strategies::all(); ///< where steps lead nowhere; none: plain arc length
  bool allow_branch_change = true;           ///< false: none of those that may
  double work = 1;                           ///< of what strategies may take, so many times the default
  bool estimates = true;                     ///< of the error, at every point
  double tolerance = 0;  ///< harmonics are chosen so that the estimate stays below; 0: they are as given
  double between = 1e-3; ///< by how much cubics between the points may miss the curve, relative

  std::filesystem::path directory; ///< output directory, absolute or relative to the working directory
  MotionWish motion;

  std::map<std::string, std::string>
      given; ///< key -> "case.toml:12" or "--out", of every key that is not left at its default

  TravellingWave wave(int sectors) const { return {sectors, engine_order.value_or(0)}; } ///< of a model of so many
  bool follows_peaks() const { return path && path->peak; }
  CurveRange range() const {
    if (path) return {path->parameter, path->from, path->to, "path.range", frequency_unit, follows_peaks()};
    if (mode) return {&modal_amplitude(), mode->from, mode->to, "mode.amplitude", frequency_unit};
    return {&frequency_parameter(), omega_from, omega_to, "continuation.omega", frequency_unit};
  }
};

/// Reads and checks case.toml. `out` (from --out) overrides output.directory; empty: not given. Throws
/// InputError.
Case read_case(const std::filesystem::path &file, const std::filesystem::path &out);

/// The settings in force for each of `n` contact points: case file first, else what the model file gave.
/// Throws InputError naming the place when a length is wrong or a parameter is missing.
std::vector<ContactPoint> contact_points(const ContactSettings &from_case, const ContactSettings &from_model, int n);

/// Frequencies in Hz become those of the model's unit of time, and are shown with its name.
void settle_units(Case &study, const Units &units);

/// Finds the contact points that a path is of. Throws InputError where the model has no such joint or points.
void settle_path(Case &study, const ContactSettings &from_model, int points);

/// Throws InputError where the path of a case is over what these contact points have not.
void check_path(const Case &study, const std::vector<ContactPoint> &points);

/// Throws InputError where a load of the case is none of `patterns`, which are those of `file`.
void check_patterns(const Case &study, const std::vector<std::string> &patterns, const std::filesystem::path &file);

/// Checks x_p0 against the number of contact points and returns 3 N_x values [m].
std::vector<double> initial_preload(const Case &study, int n);

/// Row of the watched unknown among the reduced dofs (modes first, then t1, t2, n of each contact point), or -1 where
/// none is named, or a node. Throws InputError when the model has no such one.
int watched_dof(const Case &study, int modes, int points);

/// Throws InputError where [damping] names a mode, or a matrix, that the model does not have.
void check_damping(const Case &study, int modes, int points, bool has_matrix);

/// Of a case whose model is one of that many sectors, or of none, 0. Throws InputError where a sector that is excited
/// wants an engine order, where another model has one, and where the case asks for what sectors do not have.
void settle_cyclic(Case &study, int sectors, bool has_structural, bool is_excited);

/// Sets `stability` where the case does not say: on while a point costs little, with that many reduced dofs.
void settle_stability(Case &study, int dofs);

/// Sets how a nonlinear mode is solved where the case does not say: by factors while they are quick, with that many
/// reduced dofs.
void settle_solver(Case &study, int dofs);

/// Every value in force, one per line: key, value, unit of the model, and whether it was given or is the default.
void describe(std::ostream &out, const Case &study, const std::vector<ContactPoint> &points, const Units &units);

/// Makes the output directory and checks that results.h5 can be written there. Throws InputError. For one
/// rank only.
void prepare_output(const Case &study);

} // namespace dovetail
