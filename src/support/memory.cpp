#include "support/memory.hpp"

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

} // namespace

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
    if (line.rfind("0::", 0) != 0) continue; // version 2; page cache counts as used but can be taken back
    const std::string root = "/sys/fs/cgroup";
    for (std::string group = line.substr(3); group.size() > 1; group.resize(group.rfind('/'))) {
      const double limit = number_in(root + group + "/memory.max");
      if (limit == unlimited) continue;
      const double used = number_in(root + group + "/memory.current");
      available = std::min(available, limit - used + entry_in(root + group + "/memory.stat", "inactive_file"));
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
