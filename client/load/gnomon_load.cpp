// gnomon-load: many clients in one process, to measure the load that a server carries and to check every answer.
#include <sys/resource.h>

#include <csignal>
#include <cstdio>

#include "client/cli/program.h"
#include "client/load/load_report.h"
#include "client/load/load_run.h"

namespace {

using namespace gnomon;
using namespace gnomon::client;

constexpr size_t kClientsInTable = 32;

// Ctrl-C ends the flight; clients still send Bye and the table is still printed.
volatile std::sig_atomic_t interrupted = 0;

struct Arguments {
  std::string server, scene, size, scene_folder, json, csv, codec, clients;
  uint32_t samples = 1;
  Occlusion occlusion = Occlusion::none;
  Trust trust;
  std::string transport = "auto";
  double rate_hz = 0;
  double seconds = 10;
  double warm_up = 0;
  double deadline_ms = 0;
  double may_miss_percent = 0;
  bool still = false, reopen = false;
  std::vector<std::string> tenants;
};

void declare_cameras(CLI::App& app, Arguments& a) {
  declare_rate(app, a.rate_hz, "cameras a second and client; 0: a new one as soon as one is answered");
  app.add_flag("--still", a.still, "each client asks for one frame and then stands still")->excludes("--rate");
  app.add_flag("--reopen", a.reopen, "a session that is lost meanwhile is opened again");
  app.add_option("--seconds", a.seconds, "how long is measured")->check(CLI::Range(0.1, 1e6))->type_name("S");
  app.add_option("--warm-up", a.warm_up, "how long is flown before that")
      ->check(CLI::Range(0.0, 1e6))
      ->type_name("S");
  app.add_option("--deadline-ms", a.deadline_ms, "how long after its camera an answer is of use; 0: not said")
      ->check(CLI::Range(0.0, 1e6))
      ->type_name("MS");
  app.add_option("--may-miss", a.may_miss_percent,
                 "cameras that may stay without an answer before the exit status is 3")
      ->check(CLI::Range(0.0, 100.0))
      ->type_name("PERCENT");
}

void declare(CLI::App& app, Arguments& a) {
  declare_server(app, a.server);
  declare_trust(app, a.trust);
  declare_transport(app, a.transport);
  app.add_option("--scene", a.scene, "scene that the server knows")->required()->type_name("NAME");
  app.add_option("--scene-dir", a.scene_folder, "folder of scene files, for their camera paths")->type_name("DIR");
  app.add_option("--size", a.size, "of the traced buffer")->required()->type_name("WxH");
  app.add_option(
         "--clients", a.clients,
         "how many clients, if no --tenant says it; FIRST..LAST: one run after the other, with twice as many")
      ->type_name("N|FIRST..LAST");
  declare_cameras(app, a);
  declare_codec(app, a.codec);
  declare_samples(app, a.samples);
  declare_occlusion(app, a.occlusion);
  app.add_option("--tenant", a.tenants, "clients of a tenant; may be given several times, TOKENFILE may be empty")
      ->allow_extra_args(false)
      ->type_name("NAME:TOKENFILE:CLIENTS");
  declare_json(app, a.json);
  app.add_option("--csv", a.csv, "where to write the rows of the figures as CSV")->type_name("FILE");
}

// Raises the limit of open files to its maximum, as each client has two sockets.
void allow_many_files() {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
  limit.rlim_cur = limit.rlim_max;
  setrlimit(RLIMIT_NOFILE, &limit);
}

Nanoseconds seconds_of(double seconds) {
  return std::chrono::duration_cast<Nanoseconds>(std::chrono::duration<double>(seconds));
}

Result<LoadOptions> load_options(const Arguments& a) {
  const auto server = parse_address(a.server);
  if (!server) return server.error();
  const auto size = parse_size(a.size);
  if (!size) return size.error();
  const auto transport = parse_transport(a.transport);
  if (!transport) return transport.error();
  std::vector<protocol::CodecId> codecs;
  if (!a.codec.empty()) {
    const auto codec = protocol::parse_codec(a.codec);
    if (!codec) return codec.error();
    codecs = {*codec};
  }
  return LoadOptions{.server = *server,
                     .trust = a.trust,
                     .transport = *transport,
                     .scene = a.scene,
                     .scene_folder = a.scene_folder,
                     .size = *size,
                     .codecs = codecs,
                     .samples = {a.samples, a.occlusion},
                     .rate_hz = a.rate_hz,
                     .still = a.still,
                     .reopen = a.reopen,
                     .deadline = seconds_of(a.deadline_ms / 1000),
                     .warm_up = seconds_of(a.warm_up),
                     .duration = seconds_of(a.seconds),
                     .interrupted = [] { return interrupted != 0; }};
}

// The clients of each run.
Result<std::vector<std::vector<LoadGroup>>> plan_runs(const Arguments& a) {
  std::vector<size_t> counts{0};
  if (!a.clients.empty()) {
    const auto parsed = parse_clients(a.clients);
    if (!parsed) return parsed.error();
    counts = *parsed;
  }
  std::vector<std::vector<LoadGroup>> runs;
  for (const size_t clients : counts) {
    const auto plan = plan_load(a.tenants, clients);
    if (!plan) return plan.error();
    runs.push_back(*plan);
  }
  return runs;
}

// What is wrong with a run, though it came to its end.
Result<void> check(const std::vector<LoadRow>& rows, double may_miss, Exit& after_error) {
  if (const uint64_t invalid = rows.back().figures.counters.invalid_slices) {
    return Error{std::to_string(invalid) + " slices answered no camera that was asked for, or did not decode"};
  }
  for (const LoadRow& row : rows) {
    if (!row.error.empty()) return Error{"client " + std::to_string(row.client) + ": " + row.error};
  }
  const std::string missing = without_answer(rows.back(), may_miss);
  if (missing.empty()) return {};
  after_error = Exit::unanswered;
  return Error{missing};
}

void print_lines(const std::vector<std::string>& lines) {
  for (const std::string& line : lines) std::printf("%s\n", line.c_str());
}

Result<void> write_files(const Arguments& a, const Report& report) {
  if (!a.json.empty()) {
    if (auto written = write_report(a.json, report); !written) return written;
  }
  return a.csv.empty() ? Result<void>() : write_csv(a.csv, report);
}

Result<void> run(const Arguments& a, Exit& after_error) {
  allow_many_files();
  for (const int number : {SIGINT, SIGTERM}) std::signal(number, [](int) { interrupted = 1; });
  after_error = Exit::wrong_usage;
  const auto options = load_options(a);
  if (!options) return options.error();
  auto runs = plan_runs(a);
  if (!runs) return runs.error();
  after_error = Exit::failed;
  for (auto& plan : *runs) {
    if (auto read = read_tokens(plan); !read) return read;
  }
  const bool sweep = runs->size() > 1;
  Report report{.suite = "load", .server = to_string(options->server)};
  Result<void> verdict;
  for (const auto& plan : *runs) {
    if (interrupted != 0 && !report.rows.empty()) break;
    LoadRun load(*options, plan);
    Progress progress;
    if (const auto done = load.run(progress); !done) return done;
    progress.clear();
    const auto rows = load_rows(load);
    if (report.rows.empty()) {
      print_lines(load_settings(*options, load));
      print_heading(stdout);
    }
    print_table(stdout, sweep ? std::vector{rows.back()} : rows, kClientsInTable);
    if (!sweep) print_lines(load_remarks(rows.back()));
    std::fflush(stdout);
    add_rows(report, *options, load, rows);
    if (verdict) verdict = check(rows, a.may_miss_percent / 100, after_error);
  }
  if (auto written = write_files(a, report); !written) return written;
  return verdict;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Many Gnomon clients in one process: checks every answer and measures.", "gnomon-load");
  app.set_version_flag("--version", "gnomon-load " GNOMON_VERSION);
  return run_program(app, argc, argv, declare, run);
}
