#include "client/load/load_report.h"

#include <algorithm>
#include <cstdio>
#include <map>

namespace gnomon::client {
namespace {

LoadRow client_row(size_t number, const LoadParticipant& participant, double seconds) {
  const LoadClient& client = *participant.client;
  LoadRow row;
  row.client = number;
  row.clients = 1;
  row.tenant = participant.tenant;
  row.counters = client.stream().counters();
  row.frames = row.counters.complete;
  row.vbps = seconds > 0 ? static_cast<double>(client.frames_in_time()) / seconds : 0;
  row.latencies = client.latencies();
  row.bytes = client.stream().connection().data_counters().received_bytes;
  if (const auto& failure = client.stream().connection().failure()) row.error = failure->message;
  return row;
}

void add(LoadRow& sum, const LoadRow& row) {
  sum.clients += row.clients;
  sum.counters += row.counters;
  sum.frames += row.frames;
  sum.vbps += row.vbps;
  sum.latencies.add(row.latencies);
  sum.bytes += row.bytes;
}

const char* to_string(LoadRow::Scope scope) {
  switch (scope) {
    case LoadRow::Scope::client: return "client";
    case LoadRow::Scope::tenant: return "tenant";
    case LoadRow::Scope::total: return "total";
  }
  return "";
}

double ms(const LoadRow& row, double share) { return to_milliseconds(row.latencies.percentile(share)); }

nlohmann::ordered_json to_json(const LoadRow& row) {
  nlohmann::ordered_json json = {{"scope", to_string(row.scope)}};
  if (row.scope == LoadRow::Scope::client) json["client"] = row.client;
  if (row.scope != LoadRow::Scope::total) json["tenant"] = row.tenant;
  json["clients"] = row.clients;
  json["frames"] = row.frames;
  json["vbps"] = row.vbps;
  json["p50_ms"] = ms(row, 0.5);
  json["p99_ms"] = ms(row, 0.99);
  json["bytes_per_frame"] = row.bytes_per_frame();
  json["lost_slices"] = row.counters.lost_slices;
  json["resumed"] = row.counters.resumed;
  json["wrong_frames"] = row.counters.wrong_frames;
  json["incomplete_frames"] = row.counters.incomplete;
  json["cameras"] = row.counters.asked;
  json["superseded_cameras"] = row.counters.superseded;
  json["unanswered_cameras"] = row.counters.unanswered;
  json["duplicate_slices"] = row.counters.duplicate_slices;
  json["late_slices"] = row.counters.late_slices;
  if (!row.error.empty()) json["error"] = row.error;
  return json;
}

std::string name_of(const LoadRow& row) {
  const std::string tenant = row.tenant.empty() ? "default" : row.tenant;
  switch (row.scope) {
    case LoadRow::Scope::client: return "client " + std::to_string(row.client) + " (" + tenant + ")";
    case LoadRow::Scope::tenant: return tenant + ", " + std::to_string(row.clients) + " clients";
    case LoadRow::Scope::total: return "total, " + std::to_string(row.clients) + " clients";
  }
  return {};
}

}  // namespace

double LoadRow::bytes_per_frame() const {
  const uint64_t came = counters.complete + counters.incomplete;
  return came ? static_cast<double>(bytes) / static_cast<double>(came) : 0;
}

std::vector<LoadRow> load_rows(const LoadRun& run) {
  std::vector<LoadRow> rows;
  std::map<std::string, LoadRow> tenants;
  LoadRow total;
  total.scope = LoadRow::Scope::total;
  for (const auto& participant : run.participants()) {
    rows.push_back(client_row(rows.size(), participant, run.flight_seconds()));
    LoadRow& tenant = tenants[participant.tenant];
    tenant.scope = LoadRow::Scope::tenant;
    tenant.tenant = participant.tenant;
    add(tenant, rows.back());
    add(total, rows.back());
  }
  for (auto& [name, tenant] : tenants) rows.push_back(std::move(tenant));
  rows.push_back(std::move(total));
  return rows;
}

Report load_report(const LoadOptions& options, const LoadRun& run, const std::vector<LoadRow>& rows) {
  Report report{.suite = "load", .device = to_string(options.server), .driver = ""};
  for (const auto& participant : run.participants()) {
    const auto& tracer = participant.client->stream().connection().welcome().tracer;
    if (report.driver.empty()) report.driver = tracer;
  }
  for (const LoadRow& row : rows) {
    auto json = to_json(row);
    json["scene"] = options.scene;
    json["size"] = std::to_string(options.size.width) + "x" + std::to_string(options.size.height);
    json["rate_hz"] = options.rate_hz;
    json["seconds"] = run.flight_seconds();
    report.rows.push_back(std::move(json));
  }
  return report;
}

void print_table(std::FILE* out, const std::vector<LoadRow>& rows, size_t max_clients) {
  const bool with_clients = rows.back().clients <= max_clients;
  std::fprintf(out, "%-28s %8s %8s %9s %9s %12s %6s %6s\n", "", "frames", "vbps", "p50 ms", "p99 ms", "bytes/frame",
               "lost", "wrong");
  for (const LoadRow& row : rows) {
    if (row.scope == LoadRow::Scope::client && !with_clients && row.error.empty()) continue;
    std::fprintf(out, "%-28s %8llu %8.2f %9.1f %9.1f %12.0f %6llu %6llu%s%s\n", name_of(row).c_str(),
                 static_cast<unsigned long long>(row.frames), row.vbps, ms(row, 0.5), ms(row, 0.99),
                 row.bytes_per_frame(), static_cast<unsigned long long>(row.counters.lost_slices),
                 static_cast<unsigned long long>(row.counters.wrong_frames), row.error.empty() ? "" : "  ",
                 row.error.c_str());
  }
}

}  // namespace gnomon::client
