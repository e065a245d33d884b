// gnomon-bench SUITE [--json FILE] ...: measures one part of Gnomon and prints a table.
#include <cstdio>
#include <string>
#include <vector>

#include "tests/bench/suites.h"

namespace {

struct Command {
  const char* name;
  const char* about;
  std::unique_ptr<gnomon::bench::Suite> suite;
  CLI::App* app = nullptr;
};

int run(Command& command, const std::string& json_file) {
  const auto report = command.suite->run();
  if (!report) {
    std::fprintf(stderr, "gnomon-bench %s: %s\n", command.name, report.error().message.c_str());
    return 1;
  }
  print_table(*report);
  if (json_file.empty()) return 0;
  if (const auto written = write_json(*report, json_file); !written) {
    std::fprintf(stderr, "gnomon-bench: %s\n", written.error().message.c_str());
    return 1;
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Benchmarks of Gnomon. Ratios are computed within the run that measured both sides.");
  app.require_subcommand(1);
  std::string json_file;
  std::vector<Command> commands;
  commands.push_back({"tracers", "shadow tracers beside Embree, over the same shadow segments",
                      gnomon::bench::make_tracers_suite()});
  commands.push_back(
      {"queries", "what the queries of light buffers cost, counted", gnomon::bench::make_queries_suite()});
  commands.push_back({"motion", "what instances that move cost, beside the hard shadows of what rests",
                      gnomon::bench::make_motion_suite()});
  commands.push_back({"soft", "shadow stages with 1, 4 and 16 sample points of each area light",
                      gnomon::bench::make_soft_suite()});
  commands.push_back(
      {"soft_pictures",
       "one view with hard shadows, soft ones, ambient occlusion, and by a reference: what they cost and "
       "how far they are from it",
       gnomon::bench::make_soft_pictures_suite()});
  commands.push_back({"scheduler", "what a pick costs as sessions grow, and how close shares come to the promise",
                      gnomon::bench::make_scheduler_suite()});
  commands.push_back(
      {"growth", "what a frame takes as triangles and lights grow in number", gnomon::bench::make_growth_suite()});
  commands.push_back({"codec", "bytes and milliseconds of the codecs on masks along camera paths",
                      gnomon::bench::make_codec_suite()});
  commands.push_back({"loading",
                      "what scenes cost to read and to build for in a process of their own, beside this one",
                      gnomon::bench::make_loading_suite()});
  commands.push_back({"occlusion", "how far ambient occlusion is from a reference of 1,024 segments",
                      gnomon::bench::make_occlusion_suite()});
  commands.push_back({"penumbra", "how far soft shadows are from a reference of 1,024 points",
                      gnomon::bench::make_penumbra_suite()});
  commands.push_back({"pipeline", "the whole daemon over loopback, beside its kernels run back to back",
                      gnomon::bench::make_pipeline_suite()});
  commands.push_back(
      {"transport", "what sealing, pacing and the link cost and bring", gnomon::bench::make_transport_suite()});
  for (Command& command : commands) {
    command.app = app.add_subcommand(command.name, command.about);
    command.app->add_option("--json", json_file, "write the results to this file");
    command.suite->add_options(*command.app);
  }
  CLI11_PARSE(app, argc, argv);
  for (Command& command : commands)
    if (command.app->parsed()) return run(command, json_file);
  return 1;
}
