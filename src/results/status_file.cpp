#include "results/status_file.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>

#include "results/point_record.hpp"
#include "support/version.hpp"

namespace dovetail {
namespace {

constexpr std::chrono::seconds between_points(1);

const char *state_of(const std::string &stage) {
  const char first = stage.empty() ? ' ' : stage[0];
  return first < '3' ? "reducing" : first < '5' ? "preload" : "following";
}

std::string number(double value) { // JSON has no other ones
  char text[40];
  std::snprintf(text, sizeof text, "%.15g", value);
  return std::isfinite(value) ? text : "null";
}

} // namespace

StatusFile::StatusFile(std::filesystem::path folder) {
  if (!folder.empty()) file_ = std::move(folder) / "status.json";
}

StatusFile::~StatusFile() {
  std::error_code error;
  if (written_) std::filesystem::remove(file_, error);
}

void StatusFile::stage(const std::string &name) {
  write(state_of(name), ", \"stage\": \"" + name + "\"");
  last_ = {}; // the next point at once
}

void StatusFile::point(const CurveRange &range, int points, const PointRecord &record, double left) {
  if (file_.empty() || (last_ != Clock::time_point{} && Clock::now() - last_ < between_points)) return;
  write("following",
        ", \"stage\": \"5 branch\", \"points\": " + std::to_string(points) + ", \"omega\": " + number(record.omega) +
            ", \"over\": \"" + range.parameter->name + "\", \"value\": " + number(record.parameter) +
            ", \"from\": " + number(range.from) + ", \"to\": " + number(range.to) + ", \"done\": " +
            number(std::clamp(record.progress, 0.0, 1.0)) + ", \"left\": " + (left < 0 ? "null" : number(left)));
  last_ = Clock::now();
}

void StatusFile::write(const std::string &state, const std::string &more) {
  if (file_.empty()) return;
  const std::filesystem::path partial = file_.string() + ".partial";
  const double seconds = std::chrono::duration<double>(Clock::now() - begin_).count();
  std::error_code error;
  std::ofstream stream(partial, std::ios::trunc);
  stream << "{\"program\": \"dovetail " << version << "\", \"state\": \"" << state
         << "\", \"seconds\": " << number(seconds) << more << "}\n";
  stream.close();
  if (stream)
    std::filesystem::rename(partial, file_, error), written_ = written_ || !error;
  else
    std::filesystem::remove(partial, error);
}

} // namespace dovetail
