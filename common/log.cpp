#include "common/log.h"

#include <fcntl.h>
#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/base_sink.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <mutex>

#include "common/audit_file.h"
#include "common/log_line.h"
#include "common/log_rate_limiter.h"
#include "common/patient_stream.h"
#include "common/printable.h"
#include "common/published.h"

namespace gnomon::log {
namespace {

// A logger and the format of what it is given: together, so that no line is
// half in one format and half in another.
struct Output {
  std::shared_ptr<spdlog::logger> logger;
  Format format = Format::key_value;
};

std::atomic<spdlog::level::level_enum> least_level{spdlog::level::warn};

constexpr const char* kJsonPattern = R"({"time":"%Y-%m-%dT%H:%M:%S.%e%z","level":"%l",%v)";

// Standard error where it is no terminal.
class PatientSink final : public spdlog::sinks::base_sink<std::mutex> {
 private:
  void sink_it_(const spdlog::details::log_msg& message) override {
    spdlog::memory_buf_t line;
    formatter_->format(message, line);
    if (!stream_.write({line.data(), line.size()})) count_unwritten_log_line();
  }
  void flush_() override {}

  PatientStream stream_{STDERR_FILENO};
};

std::atomic<bool> waits_for_readers{true};

spdlog::sink_ptr standard_error() {
  if (waits_for_readers || isatty(STDERR_FILENO)) return std::make_shared<spdlog::sinks::stderr_color_sink_mt>();
  return std::make_shared<PatientSink>();
}

Output output_to_stderr(Format format) {
  auto made = std::make_shared<spdlog::logger>("gnomon", standard_error());
  made->set_pattern(format == Format::json ? kJsonPattern : "%Y-%m-%dT%H:%M:%S.%e%z %^%l%$ %v");
  made->set_level(spdlog::level::trace);  // least_level decides
  return {std::move(made), format};
}

// Replaced when the format changes: a thread that is writing keeps the one that
// it began with. Never destroyed, as all that the log has of its own: threads that
// outlive main() write until the process ends.
Published<Output>& output() {
  static Published<Output>& instance = *new Published<Output>;
  static std::once_flag made;
  std::call_once(made, [] { instance.publish(output_to_stderr(Format::key_value)); });
  return instance;
}

spdlog::level::level_enum to_spdlog(Level level) {
  switch (level) {
    case Level::debug: return spdlog::level::debug;
    case Level::info: return spdlog::level::info;
    case Level::warning: return spdlog::level::warn;
    case Level::error: return spdlog::level::err;
    case Level::off: return spdlog::level::off;
  }
  return spdlog::level::info;
}

// Escapes the characters that would break a line or a JSON document, so that a
// log line never spans two lines, whatever a client has sent.
void append_quoted(std::string& out, std::string_view text) {
  std::string quoted;
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c;
  }
  out += '"' + without_controls(quoted) + '"';
}

bool is_bare(std::string_view text) {
  return !text.empty() && text.find_first_of(" \"=\\") == std::string_view::npos && without_controls(text) == text;
}

void append_value(std::string& out, const Field& field, Format format) {
  if (const auto* text = std::get_if<std::string>(&field.value)) {
    if (format == Format::key_value && is_bare(*text)) {
      out += *text;
    } else {
      append_quoted(out, *text);
    }
  } else if (const auto* flag = std::get_if<bool>(&field.value)) {
    out += *flag ? "true" : "false";
  } else if (const auto* i = std::get_if<int64_t>(&field.value)) {
    out += std::to_string(*i);
  } else if (const auto* u = std::get_if<uint64_t>(&field.value)) {
    out += std::to_string(*u);
  } else {
    char number[32];
    std::snprintf(number, sizeof number, "%.6g", std::get<double>(field.value));
    out += number;
  }
}

// Limits for each event, so that neither an unauthenticated peer nor a fault in
// every frame can fill the disk.
constexpr double kLinesAtOnce = 200, kLinesPerSecond = 20;

class SharedRateLimiter {
 public:
  std::optional<uint64_t> admit(std::string_view event) {
    std::lock_guard lock(mutex_);
    return limiter_.admit(event, Clock::now());
  }

 private:
  std::mutex mutex_;
  LogRateLimiter limiter_{kLinesAtOnce, kLinesPerSecond};  // guarded by mutex_
};

// What follows time and level.
std::string line_of(std::string_view event, Fields fields, uint64_t left_out, Format format) {
  std::string line;
  if (format == Format::json) {
    line += "\"event\":";
    append_quoted(line, event);
    for (const Field& field : fields) {
      line += ',';
      append_quoted(line, field.key);
      line += ':';
      append_value(line, field, format);
    }
    if (left_out > 0) line += ",\"left_out\":" + std::to_string(left_out);
    line += '}';
  } else {
    line += event;
    for (const Field& field : fields) {
      line += ' ';
      line += field.key;
      line += '=';
      append_value(line, field, format);
    }
    if (left_out > 0) line += " left_out=" + std::to_string(left_out);
  }
  return line;
}

void write(const Output& to, spdlog::level::level_enum level, std::string_view event, Fields fields,
           uint64_t left_out) {
  const std::string line = line_of(event, fields, left_out, to.format);
  to.logger->log(level, spdlog::string_view_t(line.data(), line.size()));
}

void write(spdlog::level::level_enum level, std::string_view event, Fields fields) {
  static SharedRateLimiter& limiter = *new SharedRateLimiter;
  if (level < least_level.load(std::memory_order_relaxed)) return;
  if (const auto left_out = limiter.admit(event)) write(*output().get(), level, event, fields, *left_out);
}

// What the file does not take, as on a full disk, goes where it would go without a file, so that it is not lost.
class AuditFileSink final : public spdlog::sinks::base_sink<std::mutex> {
 public:
  explicit AuditFileSink(const std::string& file) : name_(file), file_(file) {
    if (!waits_for_readers) stderr_.emplace(STDERR_FILENO);
  }

 private:
  void sink_it_(const spdlog::details::log_msg& message) override {
    spdlog::memory_buf_t formatted;
    formatter_->format(message, formatted);
    const std::string line(formatted.data(), formatted.size());
    const int error = file_.append(line);
    count_audit_line(error);
    if (error == 0) return;
    if (!stderr_) {
      std::fwrite(line.data(), 1, line.size(), stderr);
    } else if (!stderr_->write(line)) {
      count_unwritten_log_line();
    }
    log::error("audit log not written", {{"file", name_}, {"why", std::strerror(error)}});
  }
  void flush_() override {}

  const std::string name_;
  AuditFile file_;
  std::optional<PatientStream> stderr_;
};

// `file`: '' for standard error.
Output audit_output(const std::string& file, Format format) {
  spdlog::sink_ptr sink;
  forget_audit_error();
  if (file.empty()) {
    sink = standard_error();
  } else {
    sink = std::make_shared<AuditFileSink>(file);
  }
  auto made = std::make_shared<spdlog::logger>("audit", std::move(sink));
  made->set_pattern(format == Format::json ? R"({"time":"%Y-%m-%dT%H:%M:%S.%e%z","level":"%l","logger":"%n",%v)"
                                           : "%Y-%m-%dT%H:%M:%S.%e%z %n %v");
  return {std::move(made), format};
}

// Where the audit log goes, and its output, as those of the log.
struct Audit {
  std::mutex changing;
  std::string file;  // guarded by changing
  Published<Output> output;

  Audit() { output.publish(audit_output("", Format::key_value)); }
};

Audit& the_audit() {
  static Audit& instance = *new Audit;
  return instance;
}

}  // namespace

void configure(Level level, Format format) {
  set_level(level);
  if (output().get()->format != format) output().publish(output_to_stderr(format));
  Audit& audit = the_audit();
  std::lock_guard lock(audit.changing);
  if (audit.output.get()->format == format) return;
  audit.output.publish(audit_output(audit.file, format));
}

void leave_out_what_nobody_reads() {
  waits_for_readers = false;
  output().publish(output_to_stderr(output().get()->format));
  Audit& audit = the_audit();
  std::lock_guard lock(audit.changing);
  audit.output.publish(audit_output(audit.file, audit.output.get()->format));
}

void set_level(Level level) { least_level = to_spdlog(level); }

void debug(std::string_view event, Fields fields) { write(spdlog::level::debug, event, fields); }
void info(std::string_view event, Fields fields) { write(spdlog::level::info, event, fields); }
void warning(std::string_view event, Fields fields) { write(spdlog::level::warn, event, fields); }
void error(std::string_view event, Fields fields) { write(spdlog::level::err, event, fields); }

std::string json_line(std::string_view event, Fields fields) {
  const std::string text = line_of(event, fields, 0, Format::json);
  spdlog::memory_buf_t line;
  spdlog::pattern_formatter(kJsonPattern).format({"gnomon", spdlog::level::info, text}, line);
  return {line.data(), line.size()};
}

void audit(std::string_view event, Fields fields) {
  write(*the_audit().output.get(), spdlog::level::info, event, fields, 0);
}

void audit_refusal(std::string_view event, Fields fields) {
  static SharedRateLimiter& limiter = *new SharedRateLimiter;
  const auto left_out = limiter.admit(event);
  if (left_out) write(*the_audit().output.get(), spdlog::level::info, event, fields, *left_out);
}

Result<void> check_audit_file(const std::string& file) {
  const int made = open(file.c_str(), O_WRONLY | O_APPEND | O_CLOEXEC);
  if (made < 0) return Error{file + ": cannot be written: " + std::strerror(errno)};
  close(made);
  return {};
}

Result<void> set_audit_file(const std::string& file) {
  if (!file.empty()) {
    const int made = open(file.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0640);
    if (made < 0) return Error{file + ": cannot be written: " + std::strerror(errno)};
    close(made);
  }
  Audit& audit = the_audit();
  std::lock_guard lock(audit.changing);
  audit.output.publish(audit_output(file, output().get()->format));
  audit.file = file;
  return {};
}

}  // namespace gnomon::log
