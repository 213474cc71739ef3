#pragma once
// One run at a time in a folder.
#include <filesystem>
#include <string>

namespace dovetail {

/// Holds a folder while it lives: by a lock of the operating system on a file in it, which a process loses however it
/// ends. The file says who holds it, and goes with the lock; a killed process leaves it behind, unlocked.
class FolderLock {
public:
  /// Throws InputError if another process holds the folder, with what it says of itself and `remedy`.
  FolderLock(const std::filesystem::path &folder, const std::string &remedy);
  ~FolderLock();
  FolderLock(const FolderLock &) = delete;
  FolderLock &operator=(const FolderLock &) = delete;

  /// What to tell the user: that the file system has no locks, or nothing.
  const std::string &note() const { return note_; }
  /// What the file says, for other hosts to see; empty where it could not be written.
  const std::string &published();

  /// Throws as the constructor would if another process holds the folder now; changes nothing.
  static void refuse_held(const std::filesystem::path &folder, const std::string &remedy);
  /// Whether this process sees the file that says `text` in the folder, which another holds. Looks for it for some
  /// seconds, as file systems over a network may show it late.
  static bool sees(const std::filesystem::path &folder, const std::string &text);

private:
  std::filesystem::path file_;
  int descriptor_ = -1;
  std::string note_, text_;
};

} // namespace dovetail
