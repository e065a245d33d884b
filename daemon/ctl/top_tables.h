// What `gnomonctl top` shows: a heading, tenants, and sessions in an order and a choice that its user may change.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace gnomon::ctl {

// Columns of sessions, in their order. Rows are sorted by one of them.
enum class SessionColumn { session, tenant, scene, transport, size, vbps, queue, device, total };
inline constexpr size_t kSessionColumns = 9;

// Which sessions are shown, and in which order.
struct SessionOrder {
  SessionColumn by = SessionColumn::vbps;
  bool ascending = false;
  std::string filter = {};  // part of the session's id, tenant or scene; if empty, all sessions
};

// Two answers of /status and the time between them, from which rates are computed.
struct TopSample {
  const nlohmann::json& before;
  const nlohmann::json& now;
  double seconds = 0;
};

struct TopTables {
  std::string heading;                // one line
  std::vector<std::string> tenants;   // the titles first
  std::vector<std::string> sessions;  // the titles first; the column of the order is marked
  size_t all_sessions = 0;            // also those that the filter leaves out
};

TopTables top_tables(const TopSample& sample, const SessionOrder& order = {});

// All of it as text, as it is printed where there is no terminal.
std::string top_text(const nlohmann::json& before, const nlohmann::json& now, double seconds);

}  // namespace gnomon::ctl
