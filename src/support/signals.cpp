#include "support/signals.hpp"

#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstddef>
#include <ctime>
#include <initializer_list>
#include <iterator>

namespace dovetail {
namespace {

std::atomic<int> noted{0}, patient{0}; // a thread of MPI's may be the one that gets a signal
std::atomic<std::time_t> since{0};     // the first signal
static_assert(std::atomic<int>::is_always_lock_free && std::atomic<std::time_t>::is_always_lock_free);
int rank = 0; // set before the handler is

/// One write, for other threads write meanwhile. Nothing but what a handler may do.
void say(std::initializer_list<const char *> parts) {
  char line[512];
  std::size_t length = 0;
  for (const char *part : parts)
    for (; *part && length < sizeof line; ++part) line[length++] = *part;
  [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, line, length);
}

constexpr int stopping[] = {SIGTERM, SIGUSR1, SIGINT, SIGHUP};
bool unwanted[] = {false, false, false, false}; // ignored by whoever started the program

const char *name_of(int signal) {
  return signal == SIGTERM ? "SIGTERM" : signal == SIGUSR1 ? "SIGUSR1" : signal == SIGINT ? "SIGINT" : "SIGHUP";
}

void on_signal(int signal) {
  const std::time_t now = std::time(nullptr);
  std::time_t before = 0;
  const bool first = since.compare_exchange_strong(before, now);
  if (!first && now - before < 2) return; // launcher and batch system may both pass it on
  if (patient && first) {
    noted = signal;
    if (rank == 0) say({"dovetail: noted ", name_of(signal), ": the point under way is finished first\n"});
    return;
  }
  if (rank > 0) sleep(1), _exit(3); // rank 0 has the word, and the launcher ends all as soon as one is gone
  say({"dovetail: ended by ", name_of(signal),
       noted ? ", the second signal; the results file holds every point that was computed\n"
             : " before the first point was computed\n"});
  _exit(3);
}

void on_crash(int signal) {
  say({"dovetail: crashed (",
       signal == SIGSEGV   ? "SIGSEGV"
       : signal == SIGBUS  ? "SIGBUS"
       : signal == SIGILL  ? "SIGILL"
       : signal == SIGABRT ? "SIGABRT"
                           : "SIGFPE",
       "), in the program or one of its libraries; some of them do where memory runs out. Every point that was "
       "computed is in the results file, and --restart goes on from there\n"});
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

} // namespace

void note_ignored_signals() {
  for (std::size_t i = 0; i < std::size(stopping); ++i) {
    struct sigaction now {};
    unwanted[i] = sigaction(stopping[i], nullptr, &now) == 0 && now.sa_handler == SIG_IGN;
  }
}

void catch_signals() {
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  struct sigaction action {};
  action.sa_handler = on_signal;
  action.sa_flags = SA_RESTART;
  for (std::size_t i = 0; i < std::size(stopping); ++i)
    if (!unwanted[i]) sigaction(stopping[i], &action, nullptr);
  action.sa_handler = on_crash;
  for (const int signal : {SIGSEGV, SIGBUS, SIGILL, SIGABRT, SIGFPE}) sigaction(signal, &action, nullptr);
  for (const int signal : {SIGPIPE, SIGXFSZ}) std::signal(signal, SIG_IGN); // the write fails, and that is told
}

void only_note_signals() { patient = 1; }

void ignore_signals() {
  for (const int signal : stopping) std::signal(signal, SIG_IGN);
}

int noted_signal() { return noted; }

const char *signal_name(int signal) { return name_of(signal); }

} // namespace dovetail
