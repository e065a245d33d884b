#include "common/log.h"

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <atomic>
#include <cstdio>
#include <mutex>

#include "common/log_rate_limiter.h"

namespace gnomon::log {
namespace {

std::atomic<Format> line_format{Format::key_value};

spdlog::logger& logger() {
  static const std::shared_ptr<spdlog::logger> instance = [] {
    auto made = std::make_shared<spdlog::logger>("gnomon", std::make_shared<spdlog::sinks::stderr_color_sink_mt>());
    made->set_pattern("%Y-%m-%dT%H:%M:%S.%e %^%l%$ %v");
    made->set_level(spdlog::level::warn);
    return made;
  }();
  return *instance;
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

// Escapes the characters that would break a line or a JSON document, so that a log line never spans two lines, whatever
// a client has sent.
void append_quoted(std::string& out, std::string_view text) {
  out += '"';
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) {
      char escaped[8];
      std::snprintf(escaped, sizeof escaped, "\\u%04x", static_cast<unsigned char>(c));
      out += escaped;
    } else {
      out += c;
    }
  }
  out += '"';
}

bool is_bare(std::string_view text) {
  if (text.empty()) return false;
  for (const char c : text) {
    const auto u = static_cast<unsigned char>(c);
    if (u <= 0x20 || u == 0x7f || c == '"' || c == '=' || c == '\\') return false;
  }
  return true;
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

// Limits for each event, so that neither an unauthenticated peer nor a fault in every frame can fill the disk.
constexpr double kLinesAtOnce = 200, kLinesPerSecond = 20;

std::optional<uint64_t> admit(std::string_view event) {
  static std::mutex mutex;
  static LogRateLimiter limiter(kLinesAtOnce, kLinesPerSecond);  // guarded by mutex
  std::lock_guard lock(mutex);
  return limiter.admit(event, Clock::now());
}

void write(spdlog::level::level_enum level, std::string_view event, Fields fields) {
  if (!logger().should_log(level)) return;
  const auto left_out = admit(event);
  if (!left_out) return;
  const Format format = line_format.load(std::memory_order_relaxed);
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
    if (*left_out > 0) line += ",\"left_out\":" + std::to_string(*left_out);
    line += '}';
  } else {
    line += event;
    for (const Field& field : fields) {
      line += ' ';
      line += field.key;
      line += '=';
      append_value(line, field, format);
    }
    if (*left_out > 0) line += " left_out=" + std::to_string(*left_out);
  }
  logger().log(level, spdlog::string_view_t(line.data(), line.size()));
}

}  // namespace

void configure(Level level, Format format) {
  line_format = format;
  if (format == Format::json) {
    logger().set_pattern(R"({"time":"%Y-%m-%dT%H:%M:%S.%e","level":"%l",%v)");
  }
  set_level(level);
}

void set_level(Level level) { logger().set_level(to_spdlog(level)); }

void debug(std::string_view event, Fields fields) { write(spdlog::level::debug, event, fields); }
void info(std::string_view event, Fields fields) { write(spdlog::level::info, event, fields); }
void warning(std::string_view event, Fields fields) { write(spdlog::level::warn, event, fields); }
void error(std::string_view event, Fields fields) { write(spdlog::level::err, event, fields); }

}  // namespace gnomon::log
