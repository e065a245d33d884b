// The suites of gnomon-bench. Each adds its subcommand, whose options it owns, and stores its report when it is run.
#pragma once

#include <CLI/CLI.hpp>
#include <memory>

#include "common/result.h"
#include "tests/bench/report.h"

namespace gnomon::bench {

class Suite {
 public:
  virtual ~Suite() = default;
  virtual void add_options(CLI::App& command) = 0;
  virtual Result<Report> run() = 0;
};

std::unique_ptr<Suite> make_tracers_suite();
std::unique_ptr<Suite> make_motion_suite();
std::unique_ptr<Suite> make_queries_suite();
std::unique_ptr<Suite> make_soft_suite();
std::unique_ptr<Suite> make_soft_pictures_suite();
std::unique_ptr<Suite> make_scheduler_suite();
std::unique_ptr<Suite> make_growth_suite();
std::unique_ptr<Suite> make_codec_suite();
std::unique_ptr<Suite> make_loading_suite();
std::unique_ptr<Suite> make_occlusion_suite();
std::unique_ptr<Suite> make_penumbra_suite();
std::unique_ptr<Suite> make_pipeline_suite();
std::unique_ptr<Suite> make_transport_suite();

}  // namespace gnomon::bench
