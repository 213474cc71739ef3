#pragma once
// What every reader may do with any input: take it, or throw an InputError that names a file. Everything else ends the
// program: another exception (uncaught), a memory error or undefined behaviour (sanitizers), a message without a place.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "support/error.hpp"

namespace dovetail::fuzz {

/// A folder of this process in memory, or where TMPDIR says; gone when it ends.
class Scratch {
public:
  Scratch() {
    const char *wanted = std::getenv("TMPDIR");
    std::string name = wanted ? wanted : std::filesystem::exists("/dev/shm") ? "/dev/shm" : "/tmp";
    name += "/dovetail-fuzz-XXXXXX";
    if (!mkdtemp(name.data())) std::perror(name.c_str()), std::abort();
    path_ = name;
  }
  ~Scratch() { std::filesystem::remove_all(path_); }
  std::filesystem::path operator/(const std::string &name) const { return path_ / name; }

private:
  std::filesystem::path path_;
};

inline void write(const std::filesystem::path &file, const void *data, std::size_t size) {
  std::ofstream stream(file, std::ios::binary);
  stream.write(static_cast<const char *>(data), static_cast<std::streamsize>(size));
  if (!stream.flush()) std::perror(file.c_str()), std::abort();
}

/// Runs a reader of `file`; true if the input was taken.
template <class Read> bool taken(const std::filesystem::path &file, Read &&read) {
  try {
    read();
    return true;
  } catch (const InputError &error) {
    if (std::string(error.what()).find(file.string()) != std::string::npos) return false;
    std::fprintf(stderr, "message without its file: %s\n", error.what());
    std::abort();
  }
}

} // namespace dovetail::fuzz
