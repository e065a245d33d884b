// gnomon-bench transport: the costs and benefits of sealing, pacing and the link. The cases are in transport_*.cpp.
#include "tests/bench/transport.h"

#include <algorithm>

#include "tests/bench/suites.h"

namespace gnomon::bench {
namespace {

std::vector<TransportCase> all_cases() {
  std::vector<TransportCase> all;
  for (auto& cases : {seal_cases(), send_cases(), link_cases(), junk_cases()})
    all.insert(all.end(), cases.begin(), cases.end());
  return all;
}

class TransportSuite final : public Suite {
 public:
  void add_options(CLI::App& command) override {
    std::vector<std::string> names;
    for (const TransportCase& one : all_cases()) names.emplace_back(one.name);
    command.add_option("--case", wanted_, "only these")->check(CLI::IsMember(names));
    command.add_option("--seconds", seconds_, "of each measurement")->check(CLI::Range(0.1, 600.0));
    command.add_flag("--quick", quick_, "every path once; the figures are worth nothing");
  }

  Result<Report> run() override {
    Report report{.suite = "transport", .device = {}, .driver = {}, .rows = {}};
    const TransportOptions options{std::chrono::duration<double>(quick_ ? 0.05 : seconds_), quick_};
    for (const TransportCase& one : all_cases()) {
      if (!wanted_.empty() && std::find(wanted_.begin(), wanted_.end(), one.name) == wanted_.end()) continue;
      say(one.name);
      auto rows = one.run(options);
      if (!rows) return rows.error();
      for (auto& row : *rows) report.rows.push_back(std::move(row));
    }
    return report;
  }

 private:
  std::vector<std::string> wanted_;
  double seconds_ = 4;
  bool quick_ = false;
};

}  // namespace

std::unique_ptr<Suite> make_transport_suite() { return std::make_unique<TransportSuite>(); }

}  // namespace gnomon::bench
