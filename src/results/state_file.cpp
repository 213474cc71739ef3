#include "results/state_file.hpp"

#include <algorithm>
#include <chrono>
#include <cinttypes>
#include <cstdio>
#include <cstring>
#include <random>
#include <sstream>
#include <utility>

#include "results/counts.hpp"
#include "support/hash.hpp"

namespace dovetail {
namespace {

constexpr double pause = 0.5; // between two states [s]
constexpr int version = 20;
constexpr const char *count = "count_"; // names of the counts begin like that
constexpr double share = 50;            // and at least so many times what writing one takes

// Of all that is in the file, which is used as it stands: a bit of it changed, and the run would go on from anywhere.
std::string fingerprint(const SavedRun &run) {
  std::uint64_t hash = 0;
  const auto take = [&](double value) {
    std::uint64_t bits;
    std::memcpy(&bits, &value, sizeof bits);
    hash = mix(hash + bits + 1);
  };
  const BranchState &branch = run.branch;
  for (const std::string *text : {&run.run, &run.problem, &run.limits, &run.end}) {
    take(static_cast<double>(text->size()));
    for (const char letter : *text) take(letter);
  }
  for (const long number : {long(run.parts), run.events, long(branch.harmonics), long(branch.samples)})
    take(static_cast<double>(number));
  for_each_count(branch.counts, [&](const char *, long number) { take(static_cast<double>(number)); });
  const auto take_all = [&](const auto &values) {
    take(static_cast<double>(values.size()));
    for (const double value : values) take(value);
  };
  for (const auto *values : {&branch.y, &branch.tangent}) take_all(*values);
  for (const auto &[name, size] : branch.fields.names) {
    for (const char letter : name) take(letter);
    take(static_cast<double>(size));
  }
  take_all(branch.fields.numbers);
  take_all(branch.trail);
  for (const double value : {run.scales.frequency, run.scales.modal, run.scales.contact, run.seconds}) take(value);
  char text[24];
  std::snprintf(text, sizeof text, "%016" PRIx64, hash);
  return text;
}

template <class Values> void list(h5::Writer &file, const std::string &name, const Values &values) {
  file.rows(name, {values.size()}, 0, values.size(), &*values.begin());
}

// Names of fields with how many numbers belong to each, line by line; and back.
std::string listed(const Archive::Fields &fields) {
  std::string lines;
  for (const auto &[name, size] : fields.names) lines += name + " " + std::to_string(size) + "\n";
  return lines;
}

Archive::Fields fields_of(const std::string &lines, std::vector<double> numbers) {
  Archive::Fields fields{{}, std::move(numbers)};
  std::istringstream words(lines);
  std::string name;
  std::size_t all = 0;
  for (std::size_t size = 0; words >> name >> size && size <= fields.numbers.size() - all; all += size)
    fields.names.emplace_back(name, size);
  return fields; // read_state compares the fingerprint
}

} // namespace

std::string new_run_name() {
  std::random_device chance;
  const auto now = std::chrono::system_clock::now().time_since_epoch().count();
  const std::uint64_t number = mix(static_cast<std::uint64_t>(now) + (std::uint64_t{chance()} << 32 | chance()));
  char text[24];
  std::snprintf(text, sizeof text, "%016" PRIx64, number);
  return text;
}

void write_state(const std::filesystem::path &path, const SavedRun &run) {
  std::filesystem::path partial = path;
  partial += ".partial";
  {
    h5::Writer file(partial);
    file.attribute("format", "dovetail-state");
    file.attribute("version", version);
    file.attribute("run", run.run);
    file.attribute("problem", run.problem);
    file.attribute("limits", run.limits);
    file.attribute("end", run.end);
    file.attribute("parts", run.parts);
    file.attribute("events", run.events);
    file.attribute("harmonics", run.branch.harmonics);
    file.attribute("samples", run.branch.samples);
    for_each_count(run.branch.counts,
                   [&](const char *name, long number) { file.attribute(std::string(count) + name, number); });
    list(file, "/y", run.branch.y);
    list(file, "/tangent", run.branch.tangent);
    file.attribute("fields", listed(run.branch.fields));
    list(file, "/numbers", run.branch.fields.numbers);
    list(file, "/trail", run.branch.trail);
    list(file, "/scales", std::vector{run.scales.frequency, run.scales.modal, run.scales.contact});
    list(file, "/seconds", std::vector{run.seconds});
    file.attribute("fingerprint", fingerprint(run));
    file.flush();
    file.close();
  }
  std::filesystem::rename(partial, path);
}

SavedRun read_state(const std::filesystem::path &path) {
  const h5::Reader file(path);
  if (file.text_attribute("format") != "dovetail-state" || file.integer_attribute("version", 0) != version)
    throw InputError(path.string() + ": not the state of a run of this version; begin anew without --restart");
  SavedRun run;
  run.run = file.text_attribute("run");
  run.problem = file.text_attribute("problem");
  run.limits = file.text_attribute("limits");
  run.end = file.text_attribute("end");
  run.parts = static_cast<int>(file.integer_attribute("parts", 1));
  run.events = file.integer_attribute("events", 0);
  run.branch.harmonics = static_cast<int>(file.integer_attribute("harmonics", 0));
  run.branch.samples = static_cast<int>(file.integer_attribute("samples", 0));
  for_each_count(run.branch.counts, [&](const char *name, auto &number) {
    number = static_cast<std::decay_t<decltype(number)>>(file.integer_attribute(std::string(count) + name, 0));
  });
  run.branch.y = file.doubles("/y");
  run.branch.tangent = file.doubles("/tangent");
  run.branch.fields = fields_of(file.text_attribute("fields"), file.doubles("/numbers"));
  run.branch.trail = GrowingList(file.doubles("/trail"));
  const auto scales = file.doubles("/scales"), seconds = file.doubles("/seconds");
  const std::string damaged = path.string() + ": damaged; begin anew without --restart";
  if (scales.size() != 3 || seconds.size() != 1 || run.branch.y.empty()) throw InputError(damaged);
  run.scales = {scales[0], scales[1], scales[2]};
  run.seconds = seconds[0];
  if (fingerprint(run) != file.text_attribute("fingerprint")) throw InputError(damaged);
  return run;
}

StateKeeper::StateKeeper(MPI_Comm comm, std::filesystem::path path, SavedRun begin)
    : comm_(comm), path_(std::move(path)), run_(std::move(begin)), before_(run_.seconds), begin_(MPI_Wtime()) {
  int rank;
  MPI_Comm_rank(comm_, &rank);
  speaks_ = rank == 0;
  noted_ = !run_.branch.y.empty();
}

double StateKeeper::seconds() const { return before_ + MPI_Wtime() - begin_; }

void StateKeeper::write() {
  const double begin = MPI_Wtime();
  run_.seconds = seconds();
  write_state(path_, run_);
  written_ = MPI_Wtime(), took_ = written_ - begin;
}

void StateKeeper::take(BranchState state, ResultsFile &results) {
  results.agreement().hold([&] {
    if (!speaks_) return;
    run_.branch = std::move(state);
    run_.events = static_cast<long>(results.events().size());
    noted_ = true;
    if (MPI_Wtime() - written_ <= std::max(pause, share * took_)) return;
    results.flush(); // the points that it counts
    write();
  });
}

void StateKeeper::finish(const std::string &end) {
  on_all_ranks(comm_, [&] {
    if (!speaks_ || !noted_) return;
    run_.end = end;
    write();
  });
}

} // namespace dovetail
