// A load run's figures, as a table, as JSON and as CSV: one row for each client, for each tenant and for all of them.
#pragma once

#include <string>
#include <vector>

#include "client/cli/report.h"
#include "client/load/load_figures.h"
#include "client/load/load_run.h"

namespace gnomon::client {

struct LoadRow {
  enum class Scope { client, tenant, total };
  Scope scope = Scope::client;
  size_t client = 0;   // number within the run; of scope client
  size_t clients = 0;  // how many the row sums up
  std::string tenant;  // of scopes client and tenant
  LoadFigures figures;
  double vbps = 0;    // complete frames a second, during the flight
  std::string error;  // why the client was refused or ended early; of scope client
};

// Clients in their order, then tenants, then the total.
std::vector<LoadRow> load_rows(const LoadRun& run);

// What was run: the settings, and what the server has told of itself. One line each.
std::vector<std::string> load_settings(const LoadOptions& options, const LoadRun& run);

// Appends the run's rows.
void add_rows(Report& report, const LoadOptions& options, const LoadRun& run, const std::vector<LoadRow>& rows);
Report load_report(const LoadOptions& options, const LoadRun& run, const std::vector<LoadRow>& rows);

// For people. With more than `max_clients` clients, those without an error have no rows of their own.
void print_heading(std::FILE* out);
void print_table(std::FILE* out, const std::vector<LoadRow>& rows, size_t max_clients);

// Where the mean answer's time went, and what became of the cameras that got none. One line each.
std::vector<std::string> load_remarks(const LoadRow& total);

// What stayed without an answer, in words; empty if that is no more than `tolerated`, a share of what was offered.
std::string without_answer(const LoadRow& total, double tolerated);

}  // namespace gnomon::client
