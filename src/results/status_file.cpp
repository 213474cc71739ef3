#include "results/status_file.hpp"

#include <algorithm>
#include <fstream>

#include "results/point_record.hpp"
#include "support/json.hpp"
#include "support/version.hpp"

namespace dovetail {
namespace {

constexpr std::chrono::seconds between_points(1);

const char *state_of(const std::string &stage) {
  const char first = stage.empty() ? ' ' : stage[0];
  return first < '3' ? "reducing" : first < '5' ? "preload" : "following";
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
  write(state_of(name), member("stage", quoted(name)));
  last_ = {}; // the next point at once
}

void StatusFile::point(const CurveRange &range, int points, const PointRecord &record, double left) {
  if (file_.empty() || (last_ != Clock::time_point{} && Clock::now() - last_ < between_points)) return;
  write("following", member("stage", quoted("5 branch")) + member("points", points) + member("omega", record.omega) +
                         member("over", quoted(range.parameter->name)) + member("value", record.parameter) +
                         member("from", range.from) + member("to", range.to) +
                         member("done", std::clamp(record.progress, 0.0, 1.0)) +
                         member("left", left < 0 ? "null" : json_number(left)));
  last_ = Clock::now();
}

void StatusFile::write(const std::string &state, const std::string &more) {
  if (file_.empty()) return;
  const std::filesystem::path partial = file_.string() + ".partial";
  const double seconds = std::chrono::duration<double>(Clock::now() - begin_).count();
  std::error_code error;
  std::ofstream stream(partial, std::ios::trunc);
  stream << "{\"program\": \"dovetail " << version << "\", \"state\": \"" << state
         << "\", \"seconds\": " << json_number(seconds) << more << "}\n";
  stream.close();
  if (stream)
    std::filesystem::rename(partial, file_, error), written_ = written_ || !error;
  else
    std::filesystem::remove(partial, error);
}

} // namespace dovetail
