#include "support/log.hpp"

#include <chrono>
#include <cstdarg>
#include <cstdio>
#include <ctime>

#include "support/json.hpp"
#include "support/printable.hpp"

namespace dovetail {
namespace {

bool json = false;

// UTC, as ISO 8601 has it: zones and summer times of a cluster's machines do not matter.
std::string now() {
  using namespace std::chrono;
  const auto time = system_clock::now();
  const std::time_t seconds = system_clock::to_time_t(time);
  const auto beyond = duration_cast<milliseconds>(time - system_clock::from_time_t(seconds)).count();
  std::tm parts{};
  gmtime_r(&seconds, &parts);
  char day[32], text[48];
  std::strftime(day, sizeof day, "%Y-%m-%dT%H:%M:%S", &parts);
  std::snprintf(text, sizeof text, "%s.%03dZ", day, static_cast<int>(beyond));
  return text;
}

std::string trimmed(const std::string &text) {
  const auto first = text.find_first_not_of(" \n");
  return first == std::string::npos ? "" : text.substr(first, text.find_last_not_of(" \n") - first + 1);
}

void print_object(const std::string &text, const char *kind, const std::string &members) {
  const std::string line = "{\"time\": \"" + now() + "\"" + member("kind", quoted(kind)) + members +
                           member("text", quoted(trimmed(text))) + "}\n";
  std::fwrite(line.data(), 1, line.size(), stdout); // at once: several ranks may have something to say
  std::fflush(stdout);
}

} // namespace

void log_as_json() { json = true; }
bool logs_json() { return json; }

void log_message(const std::string &text, const char *kind, const std::string &members) {
  if (text.empty()) return;
  if (json) return print_object(text, text.rfind("note: ", 0) == 0 ? "note" : kind, members);
  std::printf("%s\n", printable(text).c_str());
  std::fflush(stdout);
}

void log_line(const char *format, ...) {
  std::va_list values, again;
  va_start(values, format);
  va_copy(again, values);
  std::string text(static_cast<std::size_t>(std::vsnprintf(nullptr, 0, format, values)), '\0');
  std::vsnprintf(text.data(), text.size() + 1, format, again);
  va_end(again);
  va_end(values);
  if (json) return print_object(text, "message", "");
  std::fwrite(text.data(), 1, text.size(), stdout);
}

void log_error(const std::string &text, const char *kind, const std::string &members) {
  std::fprintf(stderr, "dovetail: %s\n", printable(text).c_str());
  if (json) print_object(text, kind, members);
}

} // namespace dovetail
