#include "client/load/load_report.h"

#include <algorithm>
#include <cstdio>
#include <map>

#include "common/printable.h"

namespace gnomon::client {
namespace {

LoadRow client_row(size_t number, const LoadParticipant& participant, double seconds) {
  const LoadClient& client = *participant.client;
  LoadRow row;
  row.client = number;
  row.clients = 1;
  row.tenant = participant.tenant;
  row.figures = client.figures();
  row.vbps = seconds > 0 ? static_cast<double>(row.figures.frames_in_time) / seconds : 0;
  if (const auto& failure = client.stream().connection().failure()) row.error = failure->message;
  return row;
}

void add(LoadRow& sum, const LoadRow& row) {
  sum.clients += row.clients;
  sum.figures += row.figures;
  sum.vbps += row.vbps;
}

const char* to_string(LoadRow::Scope scope) {
  switch (scope) {
    case LoadRow::Scope::client: return "client";
    case LoadRow::Scope::tenant: return "tenant";
    case LoadRow::Scope::total: return "total";
  }
  return "";
}

double ms(const LoadRow& row, double share) { return to_milliseconds(row.figures.latencies.percentile(share)); }

unsigned long long whole(uint64_t count) { return count; }

std::string text_of(const char* format, auto... values) {
  char text[256];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

nlohmann::ordered_json to_json(const LoadRow& row) {
  nlohmann::ordered_json json = {{"scope", to_string(row.scope)}};
  const LoadFigures& f = row.figures;
  if (row.scope == LoadRow::Scope::client) json["client"] = row.client;
  if (row.scope != LoadRow::Scope::total) json["tenant"] = row.tenant;
  json["clients"] = row.clients;
  json["frames"] = f.counters.complete;
  json["vbps"] = row.vbps;
  json["offered"] = f.offered();
  json["answered"] = f.answered();
  json["coalesced"] = f.coalesced();
  json["dropped"] = f.dropped();
  json["p50_ms"] = ms(row, 0.5);
  json["p90_ms"] = ms(row, 0.9);
  json["p99_ms"] = ms(row, 0.99);
  json["p999_ms"] = ms(row, 0.999);
  json["mean_ms"] = f.times.response_ms();
  json["mean_queue_ms"] = f.times.queue_ms();
  json["mean_device_ms"] = f.times.device_ms();
  json["mean_encode_ms"] = f.times.encode_ms();
  json["mean_network_ms"] = f.times.network_ms();
  json["bytes_per_frame"] = f.bytes_per_frame();
  json["lost_slices"] = f.counters.lost_slices;
  json["resumed"] = f.counters.resumed;
  json["reopened"] = f.reopened;
  json["moves"] = f.counters.moved;
  json["max_gap_ms"] = to_milliseconds(f.longest_gap);
  json["invalid_slices"] = f.counters.invalid_slices;
  json["wrong_frames"] = f.counters.invalid_slices;  // deprecated name
  json["incomplete_frames"] = f.counters.incomplete;
  json["cameras"] = f.counters.asked;
  json["superseded_cameras"] = f.counters.superseded;
  json["unanswered_cameras"] = f.counters.unanswered;
  json["duplicate_slices"] = f.counters.duplicate_slices;
  json["late_slices"] = f.counters.late_slices;
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

std::vector<std::string> load_settings(const LoadOptions& options, const LoadRun& run) {
  std::string tracer, codec, samples;
  for (const auto& participant : run.participants()) {
    const auto& welcome = participant.client->stream().connection().welcome();
    if (welcome.session == SessionId{} || !tracer.empty()) continue;
    tracer = without_controls(welcome.tracer);
    codec = protocol::to_string(welcome.codec);
    const SampleCounts granted = sample_counts_of(welcome.samples);
    if (granted.per_light > 1) samples = ", " + std::to_string(granted.per_light) + " samples of each area light";
    if (granted.occlusion != Occlusion::none) samples += ", occlusion " + std::string(to_string(granted.occlusion));
  }
  const std::string size = std::to_string(options.size.width) + "x" + std::to_string(options.size.height);
  const std::string pace = options.still         ? "one camera each"
                           : options.rate_hz > 0 ? text_of("%g cameras a second each", options.rate_hz)
                                                 : "a new camera as soon as one is answered";
  return {"server " + to_string(options.server) + ", tracer " + tracer + ", codec " + codec + samples,
          "scene " + options.scene + ", " + size + ", " + pace + ", " +
              text_of("%.1f s after %.1f s of warm-up", run.flight_seconds(), to_seconds(options.warm_up))};
}

void add_rows(Report& report, const LoadOptions& options, const LoadRun& run, const std::vector<LoadRow>& rows) {
  for (const auto& participant : run.participants()) {
    const auto& tracer = participant.client->stream().connection().welcome().tracer;
    if (report.driver.empty()) report.driver = without_controls(tracer);
    report.device = device_of(report.driver);
  }
  for (const LoadRow& row : rows) {
    auto json = to_json(row);
    json["scene"] = options.scene;
    json["size"] = std::to_string(options.size.width) + "x" + std::to_string(options.size.height);
    json["rate_hz"] = options.rate_hz;
    json["seconds"] = run.flight_seconds();
    json["warm_up_seconds"] = to_seconds(options.warm_up);
    report.rows.push_back(std::move(json));
  }
}

Report load_report(const LoadOptions& options, const LoadRun& run, const std::vector<LoadRow>& rows) {
  Report report{.suite = "load", .server = to_string(options.server)};
  add_rows(report, options, run, rows);
  return report;
}

void print_heading(std::FILE* out) {
  std::fprintf(out, "%-24s %8s %8s %9s %7s %8s %8s %8s %8s %8s %9s %5s %7s\n", "", "offered", "answered",
               "coalesced", "dropped", "vbps", "p50 ms", "p90 ms", "p99 ms", "p99.9 ms", "B/frame", "lost",
               "invalid");
}

void print_table(std::FILE* out, const std::vector<LoadRow>& rows, size_t max_clients) {
  const bool with_clients = rows.back().clients <= max_clients;
  for (const LoadRow& row : rows) {
    if (row.scope == LoadRow::Scope::client && !with_clients && row.error.empty()) continue;
    const LoadFigures& f = row.figures;
    std::fprintf(out, "%-24s %8llu %8llu %9llu %7llu %8.2f %8.1f %8.1f %8.1f %8.1f %9.0f %5llu %7llu%s%s\n",
                 name_of(row).c_str(), whole(f.offered()), whole(f.answered()), whole(f.coalesced()),
                 whole(f.dropped()), row.vbps, ms(row, 0.5), ms(row, 0.9), ms(row, 0.99), ms(row, 0.999),
                 f.bytes_per_frame(), whole(f.counters.lost_slices), whole(f.counters.invalid_slices),
                 row.error.empty() ? "" : "  ", row.error.c_str());
  }
}

std::vector<std::string> load_remarks(const LoadRow& total) {
  const StageTimes& times = total.figures.times;
  std::vector<std::string> remarks;
  if (times.answers > 0 && times.knows_queue()) {
    remarks.push_back(text_of(
        "the mean answer took %.1f ms: queue %.1f, device %.1f, encoding and sending %.1f, network and client %.1f",
        times.response_ms(), times.queue_ms(), times.device_ms(), times.encode_ms(), times.network_ms()));
  } else if (times.answers > 0) {
    remarks.push_back(text_of(
        "the mean answer took %.1f ms: queue, encoding and sending %.1f, device %.1f, network and client %.1f",
        times.response_ms(), times.encode_ms(), times.device_ms(), times.network_ms()));
  }
  if (const uint64_t moved = total.figures.counters.moved; moved > 0) {
    remarks.push_back(
        text_of("sessions moved to another server %llu times; no client waited longer than %.0f ms from one "
                "frame to the next",
                whole(moved), to_milliseconds(total.figures.longest_gap)));
  }
  if (total.figures.without_answer() > 0) remarks.push_back("times are those of the cameras that were answered");
  return remarks;
}

std::string without_answer(const LoadRow& total, double tolerated) {
  const LoadFigures& f = total.figures;
  if (static_cast<double>(f.without_answer()) <= tolerated * static_cast<double>(f.offered())) return "";
  return text_of("%llu of %llu cameras stayed without an answer (%.1f%%): ", whole(f.without_answer()),
                 whole(f.offered()),
                 100 * static_cast<double>(f.without_answer()) / static_cast<double>(f.offered())) +
         text_of("%llu were coalesced, a newer one was answered in their place, and %llu dropped",
                 whole(f.coalesced()), whole(f.dropped()));
}

}  // namespace gnomon::client
