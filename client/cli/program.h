// main() of the command-line programs of client/ and of those of tests/ that use it. The only header here with CLI11.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdio>
#include <string>
#include <type_traits>

#include "client/cli/exit.h"
#include "common/result.h"
#include "common/sample_counts.h"

namespace gnomon::client {

// Parses the command line into Arguments and runs with them: `run(arguments)` or `run(arguments, after_error)`, which
// gives a Result<void>. Returns the exit status: done, wrong_usage, or after an error, which goes to standard error behind
// the program's name, what `run` has put into `after_error`, else failed.
template <class Arguments, class Run>
int run_program(CLI::App& app, int argc, char** argv, void (*declare)(CLI::App&, Arguments&), Run run) {
  Arguments arguments;
  app.option_defaults()->always_capture_default();  // --help shows them
  declare(app, arguments);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& wrong) {
    return static_cast<int>(app.exit(wrong) == 0 ? Exit::done : Exit::wrong_usage);
  }
  Exit after_error = Exit::failed;
  Result<void> done = [&] {
    if constexpr (std::is_invocable_v<Run, const Arguments&, Exit&>) {
      return run(arguments, after_error);
    } else {
      return run(arguments);
    }
  }();
  if (!done) std::fprintf(stderr, "%s: %s\n", app.get_name().c_str(), done.error().message.c_str());
  return static_cast<int>(done ? Exit::done : after_error);
}

// Options that several programs have in the same words.
inline void declare_server(CLI::App& app, std::string& server) {
  app.add_option("--server", server, "the daemon's control address")->required()->type_name("HOST:PORT");
}

inline void declare_codec(CLI::App& app, std::string& codec) {
  app.add_option("--codec", codec, "tiles_lz4, tiles_context or raw32_lz4; else as the server likes")
      ->type_name("NAME");
}

inline void declare_samples(CLI::App& app, uint32_t& samples) {
  app.add_option("--samples", samples,
                 "soft shadows: points of each light that has an extent, for each pixel; 1, 4 or 16")
      ->check(CLI::IsMember({1, 4, 16}))
      ->type_name("K");
}

inline void declare_occlusion(CLI::App& app, Occlusion& occlusion) {
  const auto take = [&occlusion](const std::string& name) {
    for (const Occlusion each : {Occlusion::none, Occlusion::half, Occlusion::full})
      if (to_string(each) == name) occlusion = each;
  };
  app.add_option_function<std::string>("--occlusion", take,
                                       "ambient occlusion: of no pixel, of a quarter of them, or of all")
      ->check(CLI::IsMember({"none", "half", "full"}))
      ->default_str("none")
      ->type_name("none|half|full");
}

inline void declare_json(CLI::App& app, std::string& file) {
  app.add_option("--json", file, "where to write the figures")->type_name("FILE");
}

inline void declare_rate(CLI::App& app, double& rate_hz, const char* help) {
  app.add_option("--rate", rate_hz, help)->check(CLI::Range(0.0, 1000.0))->type_name("HZ");
}

}  // namespace gnomon::client
