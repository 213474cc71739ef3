#include "app/own_files.hpp"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <vector>

#include "support/error.hpp"
#include "support/hdf5.hpp"

namespace dovetail {
namespace {

namespace fs = std::filesystem;

std::string beginning(const fs::path &file) {
  std::string text(64, '\0');
  std::ifstream stream(file, std::ios::binary);
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(stream.gcount()));
  return text;
}

bool is_summary(const fs::path &file) {
  const std::string text = beginning(file);
  const auto begins = [&](const char *words) { return text.rfind(words, 0) == 0; };
  return text.empty() || begins("{\n  \"program\": \"dovetail ") || begins("{\n  \"end\": \"failed\"");
}

bool is_status(const fs::path &file) {
  const std::string text = beginning(file);
  return text.empty() || text.rfind("{\"program\": \"dovetail ", 0) == 0;
}

enum class Whole { yes, or_short, or_begun }; // begun: an attribute that says what it is may be missing yet

// Whole, or cut short by a kill or a full disk: then with HDF5's first bytes, or nothing yet.
bool has_format(const fs::path &file, const std::string &format, Whole whole) {
  try {
    const std::string found = h5::Reader(file).text_attribute("format");
    return found == format || (whole == Whole::or_begun && found.empty());
  } catch (const InputError &) {
    const std::string text = beginning(file);
    const bool nothing = std::all_of(text.begin(), text.end(), [](char byte) { return byte == 0; });
    return whole != Whole::yes && (nothing || text.rfind("\x89HDF\r\n\x1a\n", 0) == 0);
  }
}

} // namespace

void refuse_foreign_files(const Case &study, bool reduce_only) {
  const auto given = study.given.find("output.directory");
  const std::string place = given == study.given.end() ? study.file.string() : given->second;
  const auto refuse = [&](const fs::path &file, const std::string &why) {
    throw InputError(place + ": output.directory = " + study.directory.string() + ": " + file.filename().string() +
                     " there " + why +
                     ", and the run would replace it; move it away, or name another folder, there or with --out");
  };
  const auto look = [&](const fs::path &file, const auto &ours) {
    std::error_code error;
    const fs::file_status status = fs::symlink_status(file, error);
    if (!fs::exists(status)) return;
    if (fs::is_symlink(status)) refuse(file, "is a symbolic link");
    if (!fs::is_regular_file(status)) refuse(file, "is not a file");
    if (!ours(file)) refuse(file, "was not written by dovetail, or is damaged");
  };
  std::vector<std::pair<std::string, std::string>> kinds;
  if (study.reduced.empty()) kinds.emplace_back("reduced", "dovetail-reduced");
  if (!reduce_only) kinds.insert(kinds.end(), {{"results", "dovetail-results"}, {"state", "dovetail-state"}});
  for (const auto &[name, format] : kinds) {
    const auto is = [&, &format = format](Whole whole) {
      return [&, whole](const fs::path &file) { return has_format(file, format, whole); };
    };
    // What is cut short can be made again, but for results.
    look(study.directory / (name + ".h5"), is(name == "results" ? Whole::yes : Whole::or_short));
    look(study.directory / (name + ".h5.partial"), is(Whole::or_begun));
  }
  look(study.directory / "summary.json", is_summary);
  for (const char *name : {"status.json", "status.json.partial"}) look(study.directory / name, is_status);
}

} // namespace dovetail
