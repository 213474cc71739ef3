#pragma once
// The run's messages on standard output: lines of text for people, or a JSON object each for programs (--log json).
#include <string>

namespace dovetail {

/// From here on each message is one line of JSON: `time`, `kind`, further members, `text`. Once, at the beginning: the
/// process has one standard output.
void log_as_json();
bool logs_json();

/// Prints a message, one or more lines. `kind` and `members` (as `member` makes them) are for JSON alone.
void log_message(const std::string &text, const char *kind = "message", const std::string &members = "");

/// The same, for text made as printf does.
[[gnu::format(printf, 1, 2)]] void log_line(const char *format, ...);

/// To standard error, behind "dovetail: "; in JSON on standard output as well.
void log_error(const std::string &text, const char *kind = "error", const std::string &members = "");

} // namespace dovetail
