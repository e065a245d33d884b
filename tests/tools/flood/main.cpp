// gnomon-flood: sends junk to a daemon's data port, some of it made from a session that it opens and listens to.
// Reports how much was sent, how many replies came back, and whether the session was served meanwhile.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "common/clock.h"
#include "tests/tools/flood/flood.h"

namespace {

using namespace gnomon;
using namespace std::chrono_literals;

constexpr auto kViewInterval = 250ms;  // of the session whose datagrams are copied

struct Arguments {
  uint16_t control_port = 0;
  std::string scene, tenant;
  double rate = 200e3;
  double seconds = 10;
};

int run(const Arguments& a) {
  daemon::TestClient victim(a.control_port);
  auto hello = daemon::TestClient::hello(a.scene);
  hello.tenant = a.tenant;
  if (!victim.join(hello)) {
    std::fputs("gnomon-flood: no session\n", stderr);
    return EXIT_FAILURE;
  }
  tests::Datagrams junk = tests::strangers_junk();
  const tests::Datagrams heard = tests::listeners_junk(victim);
  junk.insert(junk.end(), heard.begin(), heard.end());
  const TimePoint start = Clock::now();
  tests::Flood flood(victim.welcome().data_port, std::move(junk), a.rate);
  uint32_t asked = 0, served = 0;
  for (TimePoint next = start; to_seconds(Clock::now() - start) < a.seconds; ++asked) {
    const uint32_t frame = 1'000'000 + asked;
    victim.send_view(frame, 1);
    served += !victim.receive_frame(frame).empty();
    std::this_thread::sleep_until(next += kViewInterval);
  }
  flood.stop();
  const double seconds = to_seconds(Clock::now() - start);
  const nlohmann::ordered_json report{{"sent", flood.sent()},
                                      {"seconds", seconds},
                                      {"datagrams_per_s", static_cast<double>(flood.sent()) / seconds},
                                      {"replies", flood.replies()},
                                      {"victim_asked", asked},
                                      {"victim_served", served}};
  std::printf("%s\n", report.dump().c_str());
  return EXIT_SUCCESS;
}

}  // namespace

int main(int argc, char** argv) {
  Arguments arguments;
  CLI::App app("Junk for a daemon's data port on this machine, and what came back.", "gnomon-flood");
  app.add_option("--control-port", arguments.control_port, "of the daemon, on 127.0.0.1")->required();
  app.add_option("--scene", arguments.scene, "scene of the session that is listened to")->required();
  app.add_option("--tenant", arguments.tenant, "its tenant");
  app.add_option("--rate", arguments.rate, "datagrams a second; 0: as many as go")->check(CLI::Range(0.0, 1e8));
  app.add_option("--seconds", arguments.seconds, "how long")->check(CLI::Range(0.1, 1e6));
  CLI11_PARSE(app, argc, argv);
  return run(arguments);
}
