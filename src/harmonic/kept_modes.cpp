#include "harmonic/kept_modes.hpp"

#include <unistd.h>

#include <cinttypes>
#include <cstdio>
#include <cstring>

#include "support/error.hpp"
#include "support/hash.hpp"
#include "support/hdf5.hpp"

namespace dovetail {
namespace {

constexpr const char *format = "dovetail-stuck";

bool there(const std::filesystem::path &path) {
  std::error_code unreadable;
  return std::filesystem::exists(path, unreadable);
}

std::string in_hex(std::uint64_t number) {
  char text[17];
  std::snprintf(text, sizeof text, "%016" PRIx64, number);
  return text;
}

} // namespace

std::uint64_t fingerprint(const std::vector<double> &K, const std::vector<double> &M, std::size_t n) {
  std::uint64_t made = n;
  for (const std::vector<double> *matrix : {&K, &M})
    for (std::size_t j = 0; j < n; ++j)
      for (std::size_t i = j; i < n; ++i) {
        std::uint64_t bits;
        std::memcpy(&bits, &(*matrix)[j * n + i], sizeof bits);
        made = mix(made ^ bits);
      }
  return made;
}

bool read_modes(const std::filesystem::path &path, std::uint64_t fingerprint, std::vector<double> &lambda,
                std::vector<double> &modes) {
  if (!there(path)) return false;
  try {
    const h5::Reader file(path);
    const hsize_t n = lambda.size();
    if (file.text_attribute("format") != format || file.text_attribute("of") != in_hex(fingerprint) ||
        file.extent("/modes") != h5::Extent{n, n} || file.extent("/squares") != h5::Extent{n})
      return false;
    std::vector<double> squares = file.doubles("/squares"), shapes = file.doubles("/modes");
    lambda.swap(squares), modes.swap(shapes);
    return true;
  } catch (const InputError &) {
    return false;
  }
}

void keep_modes(const std::filesystem::path &path, std::uint64_t fingerprint, const std::vector<double> &lambda,
                const std::vector<double> &modes) {
  std::filesystem::path partial = path;
  partial += "." + std::to_string(getpid()) + ".partial"; // several runs of a study may share the folder
  std::error_code ignored;
  try {
    if (there(path) && h5::Reader(path).text_attribute("format") != format) return;
    {
      h5::Writer file(partial);
      const hsize_t n = lambda.size();
      file.attribute("format", format);
      file.attribute("of", in_hex(fingerprint));
      file.rows("/squares", {n}, 0, n, lambda.data());
      file.rows("/modes", {n, n}, 0, n, modes.data());
      file.flush();
    }
    std::filesystem::rename(partial, path);
  } catch (const std::runtime_error &) { // of reading, writing or renaming
    std::filesystem::remove(partial, ignored);
  }
}

} // namespace dovetail
