#include <cerrno>
#include <cstring>
#include <fstream>
#include <unistd.h>

#include "case/case.hpp"
#include "support/error.hpp"

namespace dovetail {

void prepare_output(const Case &study) {
  namespace fs = std::filesystem;
  const auto given = study.given.find("output.directory");
  const std::string place = given == study.given.end() ? study.file.string() : given->second;
  const auto refuse = [&](const std::string &path, const std::string &why) {
    throw InputError(place + ": output.directory = " + study.directory.string() + ": " + path + " " + why +
                     "; name a folder that can be written, there or with --out");
  };

  std::error_code error;
  fs::create_directories(study.directory, error);
  if (error) refuse("the folder", "cannot be made: " + error.message());
  if (!fs::is_directory(study.directory, error)) refuse("this", "is not a folder");

  std::string trial = (study.directory / ".dovetail-XXXXXX").string();
  const int descriptor = mkstemp(trial.data());
  const bool written = descriptor >= 0 && write(descriptor, "", 1) == 1;
  const std::string reason = std::strerror(errno);
  if (descriptor >= 0) close(descriptor), unlink(trial.c_str());
  if (!written) refuse("the folder", "cannot be written to: " + reason);

  const fs::path results = study.directory / "results.h5";
  if (!fs::exists(results, error)) return;
  if (!fs::is_regular_file(results, error)) refuse("results.h5 there", "is not a file");
  if (!std::ofstream(results, std::ios::app)) refuse("results.h5 there", "cannot be overwritten");
}

} // namespace dovetail
