// Structured logging: one event a line, `time level event key=value ...` or a JSON object. The time is local and names
// its zone, as RFC 3339 has it. No other header exposes spdlog.
//
//   log::info("session opened", {{"session", id.value}, {"tenant", name}});
//
// Any thread. Callers never pass a secret as a field. Each event is rate-limited; the field `left_out` of its next line
// counts the lines that were suppressed.
#pragma once

#include <concepts>
#include <cstdint>
#include <initializer_list>
#include <string>
#include <string_view>
#include <variant>

#include "common/result.h"

namespace gnomon::log {

enum class Level { debug, info, warning, error, off };

struct Field {
  std::string_view key;
  std::variant<std::string, int64_t, uint64_t, double, bool> value;

  Field(std::string_view k, bool v) : key(k), value(v) {}
  Field(std::string_view k, std::signed_integral auto v) : key(k), value(static_cast<int64_t>(v)) {}
  Field(std::string_view k, std::unsigned_integral auto v) requires(!std::same_as<decltype(v), bool>)
      : key(k), value(static_cast<uint64_t>(v)) {}
  Field(std::string_view k, std::floating_point auto v) : key(k), value(static_cast<double>(v)) {}
  Field(std::string_view k, std::string_view v) : key(k), value(std::string(v)) {}
  Field(std::string_view k, const std::string& v) : key(k), value(v) {}
  Field(std::string_view k, const char* v) : key(k), value(std::string(v)) {}
};

using Fields = std::initializer_list<Field>;

enum class Format { key_value, json };

// Selects what is written to standard error, and how; the audit log stays where it is and is written in this format too.
// Until it is called, warnings and errors are written as key=value.
void configure(Level level, Format format);
void set_level(Level level);
// From now on no line waits for who reads standard error, where that is no terminal, longer than 100 ms, and none while the
// last one has waited for nothing. For daemons: a reader that stops must not stop them. To be called once.
void leave_out_what_nobody_reads();

void debug(std::string_view event, Fields fields = {});
void info(std::string_view event, Fields fields = {});
void warning(std::string_view event, Fields fields = {});
void error(std::string_view event, Fields fields = {});

// The audit log: who did, or tried, what. Its lines are those of a logger of its own, `audit` (in the place of the level,
// or "logger" in JSON), and are written at every log level. They go to standard error, or where set_audit_file() said.
void audit(std::string_view event, Fields fields = {});          // of somebody with the right to it; never left out
void audit_refusal(std::string_view event, Fields fields = {});  // of strangers; rate-limited as other lines

// Appends the audit log to `file`, which is made with mode 0640 where it is not there; '': standard error. Called again,
// it opens the file anew, as one that was rotated needs. On an error the log stays where it was.
Result<void> set_audit_file(const std::string& file);
// Error if a file that is there could not be appended to.
Result<void> check_audit_file(const std::string& file);

}  // namespace gnomon::log
