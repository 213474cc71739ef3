#include "support/memory.hpp"

#include <malloc.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <string>

namespace dovetail {
namespace {

constexpr double unlimited = std::numeric_limits<double>::infinity();

double number_in(const std::string &path) { // "max", as cgroups write no limit, and a missing file: unlimited
  std::ifstream file(path);
  double value;
  return file >> value ? value : unlimited;
}

double entry_in(const std::string &path, const std::string &wanted) {
  std::ifstream file(path);
  std::string key;
  for (double value; file >> key;) {
    if (file >> value && key == wanted) return value;
    file.clear();
    file.ignore(std::numeric_limits<std::streamsize>::max(), '\n');
  }
  return 0;
}

// Lowers `available` to what a group of processes may still take.
void apply_limit(double &available, const std::string &folder, const char *limit_file, const char *used_file,
                 const char *reclaimable) {
  const double limit = number_in(folder + limit_file), used = number_in(folder + used_file);
  if (limit != unlimited && used != unlimited) // page cache counts as used, but can be taken back
    available = std::min(available, limit - used + entry_in(folder + "/memory.stat", reclaimable));
}

} // namespace

void give_back_large_blocks() {
  constexpr int large = 64 << 20, most = 1 << 16;
  mallopt(M_MMAP_THRESHOLD, large), mallopt(M_MMAP_MAX, most);
}

double resident_bytes() {
  std::ifstream file("/proc/self/statm");
  double size = 0, resident = 0;
  file >> size >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE));
}

double peak_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return 1024.0 * static_cast<double>(usage.ru_maxrss);
}

double available_bytes() {
  double available = 1024 * entry_in("/proc/meminfo", "MemAvailable:");
  std::ifstream groups("/proc/self/cgroup");
  for (std::string line; std::getline(groups, line);) {
    const bool second = line.rfind("0::", 0) == 0; // version 2 of control groups
    const auto first = line.find(":memory:");      // or the memory controller of version 1
    if (!second && first == std::string::npos) continue;
    std::string group = line.substr(second ? 3 : first + 8);
    if (group == "/") group.clear();
    for (;; group.resize(group.rfind('/'))) { // in a container, its own group is the root
      if (second)
        apply_limit(available, "/sys/fs/cgroup" + group, "/memory.max", "/memory.current", "inactive_file");
      else
        apply_limit(available, "/sys/fs/cgroup/memory" + group, "/memory.limit_in_bytes", "/memory.usage_in_bytes",
                    "total_inactive_file");
      if (group.empty()) break;
    }
  }
  return std::max(available, 0.0);
}

double sum_on_machine(MPI_Comm comm, double value) {
  MPI_Comm machine;
  MPI_Comm_split_type(comm, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &machine);
  MPI_Allreduce(MPI_IN_PLACE, &value, 1, MPI_DOUBLE, MPI_SUM, machine);
  MPI_Comm_free(&machine);
  return value;
}

} // namespace dovetail
