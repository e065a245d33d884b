// Structured logging: one event a line, `level event key=value ...`. spdlog stands behind this header alone.
//
//   log::info("session opened", {{"session", id.value}, {"tenant", name}});
//
// Any thread. Nothing secret is ever passed as a field. Repeated events are rate-limited; `left_out` counts them.
#pragma once

#include <concepts>
#include <cstdint>
#include <initializer_list>
#include <string>
#include <string_view>
#include <variant>

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

// Sends lines to standard error. Called once by main; before that, warnings and errors go out as key=value.
void configure(Level level, Format format);
void set_level(Level level);

void debug(std::string_view event, Fields fields = {});
void info(std::string_view event, Fields fields = {});
void warning(std::string_view event, Fields fields = {});
void error(std::string_view event, Fields fields = {});

}  // namespace gnomon::log
