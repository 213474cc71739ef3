#include "results/progress.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "support/json.hpp"
#include "support/log.hpp"

namespace dovetail {
namespace {

constexpr double quiet_seconds = 10; // between lines when nobody watches

// Whether a person watches. Under mpirun the ranks' output is a terminal of mpirun's making, so its own output decides.
bool on_terminal() {
  if (!isatty(STDOUT_FILENO)) return false;
  // The surroundings the process was born with; MPI_Init adds to them even when nobody launched it.
  std::ifstream born("/proc/self/environ");
  const std::string surroundings{std::istreambuf_iterator<char>(born), {}};
  bool launched = false;
  for (const char *mark : {"OMPI_COMM_WORLD_SIZE=", "PMI_SIZE=", "PMIX_RANK="})
    launched = launched || surroundings.find(mark) != std::string::npos;
  if (!launched) return true;
  std::error_code error;
  const auto output = std::filesystem::read_symlink("/proc/" + std::to_string(getppid()) + "/fd/1", error).string();
  return output.rfind("/dev/pts/", 0) == 0 || output.rfind("/dev/tty", 0) == 0;
}

} // namespace

Progress::Progress(bool speaks, Told told, PetscInt watched, const CurveRange &range, int points, StatusFile &status)
    : speaks_(speaks), terminal_(on_terminal()), told_(std::move(told)), watched_(watched), range_(range),
      begin_(std::chrono::steady_clock::now()), last_line_(begin_ - std::chrono::hours(1)), points_(points),
      status_(status) {}

double Progress::elapsed() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
}

void Progress::heading() const {
  if (!speaks_) return;
  if (logs_json())
    return log_message("curve over " + std::string(range_.parameter->name), "curve",
                       member("over", quoted(range_.parameter->name)) + member("from", range_.from) +
                           member("to", range_.to));
  if (of_mode()) {
    std::printf("  step %21s %15s %12s %8s   stick  slip  open   done     time     left\n",
                ("amplitude" + (told_.units.modal.empty() ? "" : " [" + told_.units.modal + "]")).c_str(),
                range_.unit.hertz ? "frequency [Hz]" : ("omega [" + range_.unit.omega + "]").c_str(), "damping",
                "Newton");
    return;
  }
  const std::string unit = told_.unit(static_cast<int>(watched_));
  const std::string what = (told_.watch.empty() ? "motion" : told_.watch) + (unit.empty() ? "" : " [" + unit + "]");
  const std::string frequency = CurveRange{.unit = range_.unit}.heading(told_.units);
  std::printf("  step %15s ", range_.heading(told_.units).c_str());
  if (range_.of_peaks) std::printf("%15s ", frequency.c_str());
  std::printf("%12s %8s   stick  slip  open   done     time     left\n", what.c_str(), "Newton");
}

void Progress::point(const PointRecord &record) {
  ++points_;
  if (!speaks_) return;
  if (before_ < 0) before_ = record.progress;
  const auto now = std::chrono::steady_clock::now();
  const bool last = record.progress >= 1;
  const double made = record.progress - before_; // since this run was begun or continued
  const double seconds_left = last ? 0 : made > 0.01 ? elapsed() * (1 - record.progress) / made : -1;
  status_.point(range_, points_, record, seconds_left);
  if (logs_json()) return log_point(record, seconds_left);
  if (!terminal_ && !last && now - last_line_ < std::chrono::duration<double>(quiet_seconds)) return;
  last_line_ = now;
  char left[32] = "";
  if (seconds_left > 0) std::snprintf(left, sizeof left, "%.0f s", seconds_left);
  if (of_mode())
    std::printf("%6d %21.8g %15.8g %12.5e", points_, record.parameter, record.omega / range_.unit.radians(),
                record.damping_ratio);
  else if (range_.of_peaks)
    std::printf("%6d %15.8g %15.8g %12.4e", points_, range_.shown(record.parameter),
                record.omega / range_.unit.radians(), record.amplitude);
  else
    std::printf("%6d %15.8g %12.4e", points_, range_.shown(record.parameter), record.amplitude);
  std::printf(" %8d %6.0f%% %4.0f%% %4.0f%% %5.0f%% %6.1f s %8s\n", record.newton, 100 * record.stick,
              100 * record.slip, 100 * record.open, 100 * std::clamp(record.progress, 0.0, 1.0), elapsed(), left);
  std::fflush(stdout);
}

// The members are named as the datasets of results.h5.
void Progress::log_point(const PointRecord &record, double seconds_left) const {
  std::string members = member("point", points_ - 1) + member("omega", record.omega);
  if (of_mode())
    members += member("modal_amplitude", record.parameter) + member("damping_ratio", record.damping_ratio);
  else if (!range_.is_sweep())
    members += member("parameter", record.parameter);
  members += member("amplitude", record.amplitude) + member("unknown", quoted(told_.name(record.unknown))) +
             member("unit", quoted(told_.unit(record.unknown))) + member("harmonics", record.harmonics) +
             member("located", record.located) + member("newton_iterations", record.newton) +
             member("linear_iterations", record.linear) + member("residual", record.residual) +
             member("stick", record.stick) + member("slip", record.slip) + member("open", record.open) +
             member("seconds", record.seconds) + member("done", std::clamp(record.progress, 0.0, 1.0)) +
             member("left", seconds_left < 0 ? "null" : json_number(seconds_left));
  log_message(range_.text(record.parameter) + ": " + told_.amplitude(record.unknown, record.amplitude), "point",
              members);
}

void Progress::event(const BranchEvent &event, const EventRecord &record) {
  if (!speaks_) return;
  if (!logs_json() && !terminal_ && event.kind == BranchEvent::Kind::cut) return;
  const std::string whose =
      event.kind == BranchEvent::Kind::peak ? " of " + told_.amplitude(record.unknown, record.amplitude) : "";
  if (logs_json()) {
    std::string members = member("event", quoted(event_names()[static_cast<std::size_t>(record.kind)])) +
                          member("point", record.point) + member("omega", record.omega);
    if (!range_.is_sweep()) members += member("parameter", record.parameter);
    if (record.amplitude > 0)
      members += member("amplitude", record.amplitude) + member("unknown", quoted(told_.name(record.unknown)));
    return log_message(event.text + whose, "event", members);
  }
  std::printf("       %15.8g %s%s\n", range_.shown(record.parameter), event.text.c_str(), whose.c_str());
  std::fflush(stdout);
}

} // namespace dovetail
