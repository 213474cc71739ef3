#include "support/folder_lock.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <ctime>
#include <thread>

#include "support/error.hpp"

namespace dovetail {
namespace {

constexpr const char *mine = "process "; // how such a file begins

std::string about_me() {
  char host[256] = "", when[64] = "";
  gethostname(host, sizeof host - 1);
  const std::time_t now = std::time(nullptr);
  std::strftime(when, sizeof when, "%Y-%m-%d %H:%M:%S", std::localtime(&now));
  return mine + std::to_string(getpid()) + " on " + host + ", since " + when;
}

std::string holder(int descriptor) {
  char text[512];
  const ssize_t length = pread(descriptor, text, sizeof text, 0);
  return length > 0 ? std::string(text, static_cast<std::size_t>(length)) : "a process that has not said its name yet";
}

// False where the file was removed between opening and locking it: by a run that ended just then.
bool is_still(int descriptor, const std::filesystem::path &file) {
  struct stat opened {
  }, named{};
  return fstat(descriptor, &opened) == 0 && stat(file.c_str(), &named) == 0 && opened.st_dev == named.st_dev &&
         opened.st_ino == named.st_ino;
}

constexpr const char *name = "dovetail.lock";

// 0, or the error number of a file system without locks. Throws if another process has it. `kind`: LOCK_EX to hold the
// folder, LOCK_SH to look whether it is held: several ranks look at once.
int lock(int descriptor, int kind, const std::filesystem::path &folder, const std::string &remedy) {
  using namespace std::chrono;
  constexpr seconds patience(1); // with those that only look, as `dovetail watch` does
  const auto begin = steady_clock::now();
  const auto wait = [&] { return kind == LOCK_EX && steady_clock::now() - begin < patience; };
  int failed;
  while ((failed = flock(descriptor, kind | LOCK_NB)) && (errno == EINTR || (errno == EWOULDBLOCK && wait())))
    std::this_thread::sleep_for(milliseconds(1));
  if (failed && errno == EWOULDBLOCK) {
    const std::string who = holder(descriptor);
    close(descriptor);
    throw InputError(folder.string() + ": another run is writing there (" + who + "); wait for its end, or " + remedy);
  }
  return failed ? errno : 0;
}

} // namespace

void FolderLock::refuse_held(const std::filesystem::path &folder, const std::string &remedy) {
  const int descriptor = open((folder / name).c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW);
  if (descriptor < 0) return; // nobody has begun there
  lock(descriptor, LOCK_SH, folder, remedy);
  close(descriptor);
}

FolderLock::FolderLock(const std::filesystem::path &folder, const std::string &remedy) : file_(folder / name) {
  for (;;) {
    descriptor_ = open(file_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666);
    if (descriptor_ < 0)
      throw InputError(file_.string() + ": cannot be opened: " + std::strerror(errno) + "; " + remedy);
    const int failed = lock(descriptor_, LOCK_EX, folder, remedy);
    if (failed) { // file systems over a network may have none
      note_ = "note: " + folder.string() +
              ": nothing guards this folder against a second run, as its file system has "
              "no locks (" +
              std::strerror(failed) + ")";
      break;
    }
    if (is_still(descriptor_, file_)) break;
    close(descriptor_);
  }
  if (struct stat now{}; fstat(descriptor_, &now) == 0 && now.st_size > 0 && holder(descriptor_).rfind(mine, 0) != 0) {
    close(descriptor_);
    throw InputError(file_.string() + ": was not written by dovetail, and the run would replace it; move it away");
  }
  const std::string text = about_me();
  const bool told = ftruncate(descriptor_, 0) == 0 && // a lock holds without a name, too
                    pwrite(descriptor_, text.data(), text.size(), 0) >= 0;
  if (told) text_ = text;
}

const std::string &FolderLock::published() {
  if (fsync(descriptor_)) text_.clear();
  return text_;
}

bool FolderLock::sees(const std::filesystem::path &folder, const std::string &text) {
  using namespace std::chrono;
  constexpr seconds patience(10);
  const auto begin = steady_clock::now();
  for (milliseconds pause(1);; pause = std::min(2 * pause, milliseconds(500))) {
    const int descriptor = open((folder / name).c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
    const bool found = descriptor >= 0 && holder(descriptor) == text;
    if (descriptor >= 0) close(descriptor);
    if (found || steady_clock::now() - begin > patience) return found;
    std::this_thread::sleep_for(pause);
  }
}

FolderLock::~FolderLock() {
  unlink(file_.c_str());
  close(descriptor_);
}

} // namespace dovetail
