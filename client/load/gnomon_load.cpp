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
  std::string server, scene, size, scene_folder, json, codec;
  Trust trust;
  std::string transport = "auto";
  size_t clients = 0;
  double rate_hz = 0;
  double seconds = 10;
  double deadline_ms = 0;
  bool still = false;
  std::vector<std::string> tenants;
};

void declare(CLI::App& app, Arguments& a) {
  declare_server(app, a.server);
  declare_trust(app, a.trust);
  declare_transport(app, a.transport);
  app.add_option("--scene", a.scene, "scene that the server knows")->required()->type_name("NAME");
  app.add_option("--scene-dir", a.scene_folder, "folder of scene files, for their camera paths")->type_name("DIR");
  app.add_option("--size", a.size, "of the traced buffer")->required()->type_name("WxH");
  app.add_option("--clients", a.clients, "how many clients, if no --tenant says it")->type_name("N");
  declare_rate(app, a.rate_hz, "cameras a second and client; 0: a new one as soon as one is answered");
  app.add_flag("--still", a.still, "each client asks for one frame and then stands still")->excludes("--rate");
  app.add_option("--seconds", a.seconds, "how long")->check(CLI::Range(0.1, 1e6))->type_name("S");
  declare_codec(app, a.codec);
  app.add_option("--deadline-ms", a.deadline_ms, "how long after its camera an answer is of use; 0: not said")
      ->check(CLI::Range(0.0, 1e6))
      ->type_name("MS");
  app.add_option("--tenant", a.tenants, "clients of a tenant; may be given several times, TOKENFILE may be empty")
      ->allow_extra_args(false)
      ->type_name("NAME:TOKENFILE:CLIENTS");
  declare_json(app, a.json);
}

// Raises the limit of open files to its maximum, as each client has two sockets.
void allow_many_files() {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
  limit.rlim_cur = limit.rlim_max;
  setrlimit(RLIMIT_NOFILE, &limit);
}

Result<void> run(const Arguments& a) {
  allow_many_files();
  for (const int number : {SIGINT, SIGTERM}) std::signal(number, [](int) { interrupted = 1; });
  const auto server = parse_address(a.server);
  if (!server) return server.error();
  const auto size = parse_size(a.size);
  if (!size) return size.error();
  const auto transport = parse_transport(a.transport);
  if (!transport) return transport.error();
  const auto plan = plan_load(a.tenants, a.clients);
  if (!plan) return plan.error();

  std::vector<protocol::CodecId> codecs;
  if (!a.codec.empty()) {
    const auto codec = protocol::parse_codec(a.codec);
    if (!codec) return codec.error();
    codecs = {*codec};
  }

  const LoadOptions options{
      .server = *server,
      .trust = a.trust,
      .transport = *transport,
      .scene = a.scene,
      .scene_folder = a.scene_folder,
      .size = *size,
      .codecs = codecs,
      .rate_hz = a.rate_hz,
      .still = a.still,
      .deadline = std::chrono::duration_cast<Nanoseconds>(std::chrono::duration<double, std::milli>(a.deadline_ms)),
      .duration = std::chrono::duration_cast<Nanoseconds>(std::chrono::duration<double>(a.seconds)),
      .interrupted = [] { return interrupted != 0; }};
  LoadRun load(options, *plan);
  Progress progress;
  if (const auto done = load.run(progress); !done) return done;
  progress.clear();

  const auto rows = load_rows(load);
  print_table(stdout, rows, kClientsInTable);
  if (!a.json.empty()) {
    if (const auto written = write_report(a.json, load_report(options, load, rows)); !written) return written;
  }
  if (const uint64_t wrong = rows.back().counters.wrong_frames) {
    return Error{std::to_string(wrong) + " slices answered no camera that was asked for, or did not decode"};
  }
  for (const LoadRow& row : rows) {
    if (!row.error.empty()) return Error{"client " + std::to_string(row.client) + ": " + row.error};
  }
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Many Gnomon clients in one process: checks every answer and measures.", "gnomon-load");
  return run_program(app, argc, argv, declare, run);
}
