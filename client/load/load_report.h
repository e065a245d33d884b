// A load run's figures, as a table and as JSON: one row for each client, for each tenant and for all of them.
#pragma once

#include <string>
#include <vector>

#include "client/cli/latency.h"
#include "client/cli/report.h"
#include "client/load/load_run.h"

namespace gnomon::client {

struct LoadRow {
  enum class Scope { client, tenant, total };
  Scope scope = Scope::client;
  size_t client = 0;   // number within the run; of scope client
  size_t clients = 0;  // how many the row sums up
  std::string tenant;  // of scopes client and tenant
  StreamCounters counters;
  uint64_t frames = 0;  // complete, of the whole run
  double vbps = 0;      // complete frames a second, during the flight
  Latencies latencies;
  uint64_t bytes = 0;
  std::string error;  // why the client was refused or ended early; of scope client

  double bytes_per_frame() const;
};

// Clients in their order, then tenants, then the total.
std::vector<LoadRow> load_rows(const LoadRun& run);

Report load_report(const LoadOptions& options, const LoadRun& run, const std::vector<LoadRow>& rows);

// For people. With more than `max_clients` clients, those without an error have no rows of their own.
void print_table(std::FILE* out, const std::vector<LoadRow>& rows, size_t max_clients);

}  // namespace gnomon::client
