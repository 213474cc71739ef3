#include "results/summary.hpp"

#include <algorithm>
#include <cstdio>
#include <fstream>

#include "results/gather.hpp"
#include "support/version.hpp"

namespace dovetail {
namespace {

std::string quoted(const std::string &text) { // as a JSON string
  std::string out = "\"";
  for (const char c : text) {
    char escaped[8];
    if (c == '"' || c == '\\')
      (out += '\\') += c;
    else if (static_cast<unsigned char>(c) < 0x20)
      std::snprintf(escaped, sizeof escaped, "\\u%04x", c), out += escaped;
    else
      out += c;
  }
  return out + "\"";
}

std::string list(const double *values, int count, int stride) {
  std::string out = "[";
  char number[32];
  for (int r = 0; r < count; ++r) {
    std::snprintf(number, sizeof number, "%s%.6g", r ? ", " : "", values[r * stride]);
    out += number;
  }
  return out + "]";
}

const char *name_of(BranchSummary::End end) {
  switch (end) {
  case BranchSummary::End::arrived:
    return "arrived";
  case BranchSummary::End::max_points:
    return "max_points";
  case BranchSummary::End::stalled:
    return "stalled";
  case BranchSummary::End::peaks:
    return "peaks";
  case BranchSummary::End::amplitude:
    return "amplitude";
  case BranchSummary::End::interrupted:
    return "interrupted";
  case BranchSummary::End::retraced:
    return "retraced";
  case BranchSummary::End::turned_back:
    return "turned_back";
  case BranchSummary::End::no_start:
    return "no_start";
  }
  return "?";
}

} // namespace

void write_summary(MPI_Comm comm, const std::filesystem::path &directory, const BranchSummary *branch,
                   double frequency_scale, const Stages &stages, const ReductionFigures *reduction) {
  int rank, ranks;
  MPI_Comm_rank(comm, &rank);
  MPI_Comm_size(comm, &ranks);
  std::vector<double> own;
  for (const auto &record : stages.records()) own.insert(own.end(), {record.seconds, record.cpu, record.peak_mib});
  const std::vector<double> all = gather(comm, own); // (ranks, stages, 3)
  std::vector<double> forecast;
  if (reduction) forecast = gather(comm, {reduction->forecast_mib});
  on_all_ranks(comm, [&] {
    if (rank != 0) return;
    const int count = static_cast<int>(stages.records().size());
    std::ofstream file(directory / "summary.json");
    file << "{\n  \"program\": " << quoted(std::string("dovetail ") + version + " " + git_revision)
         << ",\n  \"ranks\": " << ranks << ",\n";
    if (branch) {
      char omega[32];
      std::snprintf(omega, sizeof omega, "%.17g", branch->omega * frequency_scale);
      file << "  \"end\": " << quoted(name_of(branch->end)) << ",\n  \"why\": " << quoted(branch->why)
           << ",\n  \"points\": " << branch->counts.points << ",\n  \"failures\": " << (branch->good() ? 0 : 1)
           << ",\n  \"step_cuts\": " << branch->counts.cuts << ",\n  \"folds\": " << branch->counts.folds
           << ",\n  \"corners\": " << branch->counts.corners << ",\n  \"harmonics\": " << branch->counts.harmonics
           << ",\n  \"integrations\": " << branch->counts.integrations << ",\n  \"leaps\": " << branch->counts.leaps
           << ",\n  \"missed\": " << branch->counts.missed << ",\n  \"newton_iterations\": " << branch->counts.newton
           << ",\n  \"linear_iterations\": " << branch->counts.linear << ",\n  \"last_omega\": " << omega << ",\n";
    }
    if (reduction) {
      char numbers[128];
      std::snprintf(numbers, sizeof numbers, "\"flops\": %.6g, \"backward_error\": %.3g, \"kept_psi\": %s",
                    reduction->flops, reduction->backward_error, reduction->kept_psi ? "true" : "false");
      file << "  \"reduction\": {\"ordering\": " << quoted(reduction->ordering) << ", " << numbers
           << ", \"forecast_mib\": " << list(forecast.data(), ranks, 1) << "},\n";
    }
    file << "  \"stages\": [";
    for (int s = 0; s < count; ++s)
      file << (s ? ",\n    " : "\n    ") << "{\"name\": " << quoted(stages.records()[s].name)
           << ", \"seconds\": " << list(&all[3 * s], ranks, 3 * count)
           << ", \"cpu\": " << list(&all[3 * s + 1], ranks, 3 * count)
           << ", \"peak_mib\": " << list(&all[3 * s + 2], ranks, 3 * count) << "}";
    file << "\n  ]\n}\n";
    if (!file.flush())
      throw ComputeError((directory / "summary.json").string() + ": cannot be written (is the disk full?)");

    std::printf("\n  stage                  seconds       cpu   peak memory per rank\n");
    for (int s = 0; s < count; ++s) {
      double most[3] = {0, 0, 0}; // of any rank
      for (int r = 0; r < ranks; ++r)
        for (int i = 0; i < 3; ++i) most[i] = std::max(most[i], all[3 * (r * count + s) + i]);
      std::printf("  %-20s %9.3f %9.3f %12.0f MiB\n", stages.records()[s].name.c_str(), most[0], most[1], most[2]);
    }
    if (!branch) return;
    std::printf("  %d points, %ld Newton iterations, %d step cut%s, %d turning point%s\n", branch->counts.points,
                branch->counts.newton, branch->counts.cuts, branch->counts.cuts == 1 ? "" : "s", branch->counts.folds,
                branch->counts.folds == 1 ? "" : "s");
    if (branch->counts.leaps > 0)
      std::printf("  %d leap%s where the curve could not be followed: the branch may have changed there\n",
                  branch->counts.leaps, branch->counts.leaps == 1 ? "" : "s");
    if (branch->counts.missed > 0)
      std::printf("  %d frequencies of continuation.at without solution\n", branch->counts.missed);
  });
}

void note_failure(const std::filesystem::path &directory, const std::string &failure) noexcept {
  const auto path = directory / "summary.json";
  std::error_code error;
  if (std::filesystem::exists(path, error)) return;
  std::ofstream(path) << "{\n  \"end\": \"failed\",\n  \"why\": " << quoted(failure) << ",\n  \"failures\": 1\n}\n";
}

} // namespace dovetail
