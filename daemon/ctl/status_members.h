// Reads members of /status. Those that a daemon of another version lacks are read as empty or 0; names, which others
// chose, come without what would disturb a terminal.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "common/printable.h"
#include "daemon/ctl/table.h"

namespace gnomon::ctl {

inline std::string text(const nlohmann::json& from, const char* key) {
  return without_controls(from.value(key, std::string()));
}

inline double number(const nlohmann::json& from, const char* key) { return from.value(key, 0.0); }

inline std::string whole(const nlohmann::json& from, const char* key) { return fixed(number(from, key), 0); }

inline std::string in_ms(const nlohmann::json& from, const char* key_of_us) {
  return fixed(number(from, key_of_us) / 1000, 1);
}

inline std::string size_of(const nlohmann::json& session) {
  return whole(session, "width") + "x" + whole(session, "height");
}

inline const nlohmann::json& list(const nlohmann::json& from, const char* key) {
  static const nlohmann::json none = nlohmann::json::array();
  const auto found = from.find(key);
  return found != from.end() && found->is_array() ? *found : none;
}

inline std::string state_of(const nlohmann::json& status) {
  if (status.value("stopping", false)) return "stopping";
  if (status.value("draining", false)) return "draining: admits nobody";
  return status.value("ready", false) ? "ready" : "not ready";
}

}  // namespace gnomon::ctl
