#include "results/progress.hpp"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>

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

// Largest motion of any contact dof (any mode, without contact), by the root of the sum of squared harmonics.
double largest_motion(const PointRecord &record, PetscInt modes) {
  const int width = 2 * record.harmonics + 1;
  const PetscInt dofs = static_cast<PetscInt>(record.coefficients.size()) / width;
  double largest = 0;
  for (PetscInt d = modes < dofs ? modes : 0; d < dofs; ++d) {
    double sum = 0;
    for (int i = 1; i < width; ++i) sum += std::pow(record.coefficients[d * width + i], 2);
    largest = std::max(largest, sum);
  }
  return std::sqrt(largest);
}

} // namespace

Progress::Progress(bool speaks, const Layout &layout, std::string length_unit, const CurveRange &range, int points)
    : speaks_(speaks), terminal_(on_terminal()), modes_(layout.modes), length_unit_(std::move(length_unit)),
      range_(range), begin_(std::chrono::steady_clock::now()), last_line_(begin_ - std::chrono::hours(1)),
      points_(points) {}

double Progress::elapsed() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
}

void Progress::heading() const {
  if (speaks_)
    std::printf("  step %15s   motion [%s]   Newton   stick  slip  open   done     time     left\n",
                range_.heading().c_str(), length_unit_.c_str());
}

void Progress::point(const PointRecord &record) {
  ++points_;
  if (!speaks_) return;
  if (before_ < 0) before_ = record.progress;
  const auto now = std::chrono::steady_clock::now();
  const bool last = record.progress >= 1;
  if (!terminal_ && !last && now - last_line_ < std::chrono::duration<double>(quiet_seconds)) return;
  last_line_ = now;
  const double made = record.progress - before_; // since this run was begun or continued
  char left[32] = "";
  if (made > 0.01 && !last) std::snprintf(left, sizeof left, "%.0f s", elapsed() * (1 - record.progress) / made);
  std::printf("%6d %15.8g %12.4e %8d %6.0f%% %4.0f%% %4.0f%% %5.0f%% %6.1f s %8s\n", points_,
              range_.shown(range_.is_sweep() ? record.omega : record.parameter), largest_motion(record, modes_),
              record.newton, 100 * record.stick, 100 * record.slip, 100 * record.open,
              100 * std::clamp(record.progress, 0.0, 1.0), elapsed(), left);
  std::fflush(stdout);
}

void Progress::event(const BranchEvent &event, double scale) {
  if (!speaks_ || (!terminal_ && event.kind == BranchEvent::Kind::cut)) return;
  std::printf("       %15.8g %s\n", range_.shown(event.parameter * scale), event.text.c_str());
  std::fflush(stdout);
}

} // namespace dovetail
