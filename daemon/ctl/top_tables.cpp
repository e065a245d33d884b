#include "daemon/ctl/top_tables.h"

#include <algorithm>
#include <array>
#include <map>
#include <sstream>

#include "daemon/ctl/status_members.h"

namespace gnomon::ctl {
namespace {

using nlohmann::json;

constexpr std::array<const char*, kSessionColumns> kTitles = {
    "SESSION", "TENANT", "SCENE", "TRANSPORT", ">SIZE", ">VBPS", ">QUEUE ms", ">GPU ms", ">TOTAL ms"};

struct Rated {
  const json* session;
  double vbps;
};

// Frames by session id.
std::map<std::string, double> frames_of(const json& status) {
  std::map<std::string, double> frames;
  for (const json& session : list(status, "sessions")) frames[text(session, "id")] = number(session, "frames");
  return frames;
}

std::vector<Rated> rated(const TopSample& sample) {
  const auto earlier = frames_of(sample.before);
  std::vector<Rated> all;
  for (const json& session : list(sample.now, "sessions")) {
    const auto found = earlier.find(text(session, "id"));
    const double since = number(session, "frames") - (found == earlier.end() ? 0 : found->second);
    all.push_back({&session, sample.seconds > 0 ? since / sample.seconds : 0});
  }
  return all;
}

// What a column of figures is sorted by.
double figure(const Rated& row, SessionColumn column) {
  const json& s = *row.session;
  switch (column) {
    case SessionColumn::size: return number(s, "width") * number(s, "height");
    case SessionColumn::vbps: return row.vbps;
    case SessionColumn::queue: return number(s, "queue_us");
    case SessionColumn::device: return number(s, "gpu_us");
    case SessionColumn::total: return number(s, "total_us");
    default: return 0;
  }
}

// What a column of names is sorted by; nullptr for a column of figures.
const char* name_key(SessionColumn column) {
  switch (column) {
    case SessionColumn::session: return "id";
    case SessionColumn::tenant: return "tenant";
    case SessionColumn::scene: return "scene";
    case SessionColumn::transport: return "transport";
    default: return nullptr;
  }
}

void sort(std::vector<Rated>& rows, const SessionOrder& order) {
  const char* const name = name_key(order.by);
  const auto before = [&](const Rated& a, const Rated& b) {
    if (name) return text(*a.session, name) < text(*b.session, name);
    return figure(a, order.by) < figure(b, order.by);
  };
  std::stable_sort(rows.begin(), rows.end(),
                   [&](const Rated& a, const Rated& b) { return order.ascending ? before(a, b) : before(b, a); });
}

bool is_shown(const json& session, const std::string& filter) {
  const auto has = [&](const char* key) { return text(session, key).find(filter) != std::string::npos; };
  return filter.empty() || has("id") || has("tenant") || has("scene");
}

std::vector<std::string> lines_of(const Table& table) {
  std::vector<std::string> lines;
  std::istringstream text(table.text());
  for (std::string line; std::getline(text, line);) lines.push_back(line);
  return lines;
}

std::vector<std::string> tenant_lines(const json& status, const std::vector<Rated>& sessions) {
  Table table({"TENANT", ">WEIGHT", ">SESSIONS", ">VBPS", ">SHARE", ">BY WEIGHT", ">LAG ms"});
  for (const json& tenant : list(status, "tenants")) {
    double vbps = 0;
    for (const Rated& each : sessions) {
      if (text(*each.session, "tenant") == text(tenant, "name")) vbps += each.vbps;
    }
    table.add({text(tenant, "name"), whole(tenant, "weight"), whole(tenant, "sessions"), fixed(vbps, 1),
               percent(number(tenant, "share")), percent(number(tenant, "expected_share")),
               fixed(number(tenant, "lag_ms"), 1)});
  }
  return lines_of(table);
}

std::vector<std::string> session_lines(const std::vector<Rated>& rows, const SessionOrder& order) {
  std::vector<std::string> titles(kTitles.begin(), kTitles.end());
  titles[static_cast<size_t>(order.by)] += order.ascending ? " ^" : " v";
  Table table(titles);
  for (const Rated& each : rows) {
    const json& s = *each.session;
    if (!is_shown(s, order.filter)) continue;
    table.add({text(s, "id"), text(s, "tenant"), text(s, "scene"), text(s, "transport"), size_of(s),
               fixed(each.vbps, 1), in_ms(s, "queue_us"), in_ms(s, "gpu_us"), in_ms(s, "total_us")});
  }
  return lines_of(table);
}

}  // namespace

TopTables top_tables(const TopSample& sample, const SessionOrder& order) {
  std::vector<Rated> sessions = rated(sample);
  sort(sessions, order);
  double vbps = 0;
  for (const Rated& each : sessions) vbps += each.vbps;
  const json& now = sample.now;
  TopTables tables;
  tables.heading = "gnomond " + text(now, "version") + "  " + state_of(now) + "  policy " + text(now, "policy") +
                   "  sessions " + std::to_string(sessions.size()) + "  vbps " + fixed(vbps, 1) + "  Jain " +
                   fixed(number(now, "jain"), 3) + "  worst lag " + fixed(number(now, "worst_lag_ms"), 1) + " ms";
  tables.tenants = tenant_lines(now, sessions);
  tables.sessions = session_lines(sessions, order);
  tables.all_sessions = sessions.size();
  return tables;
}

std::string top_text(const json& before, const json& now, double seconds) {
  const TopTables tables = top_tables({before, now, seconds});
  std::string out = tables.heading + "\n\n";
  for (const std::string& line : tables.tenants) out += line + "\n";
  out += "\n";
  for (const std::string& line : tables.sessions) out += line + "\n";
  return out;
}

}  // namespace gnomon::ctl
