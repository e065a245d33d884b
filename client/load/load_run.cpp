#include "client/load/load_run.h"

#include <algorithm>
#include <cstdio>

#include "client/media/scene_file.h"
#include "scenes/loader.h"

namespace gnomon::client {
namespace {

using namespace std::chrono_literals;

// Answers that are pending when the flight ends are waited for this long, or twice as long as the slowest took.
constexpr Nanoseconds kLandingTime = 1s;
constexpr Nanoseconds kLongestLanding = 15s;
constexpr auto kProgressInterval = 100ms;

LoadClient::Options client_options(const LoadOptions& options, const LoadGroup& group, double phase) {
  LoadClient::Options client;
  auto& connect = client.stream.connect;
  connect.server = options.server;
  connect.trust = options.trust;
  connect.transport = options.transport;
  connect.timeout = 30s;  // hundreds shake hands at once
  connect.hello.client = "gnomon-load";
  connect.hello.tenant = group.tenant;
  connect.hello.token = group.token;
  connect.hello.scene = options.scene;
  connect.hello.width = options.size.width;
  connect.hello.height = options.size.height;
  connect.hello.codecs = options.codecs;
  client.stream.samples = options.samples;
  connect.hello.rate_hz = static_cast<float>(options.rate_hz);
  // With a rate, cameras are sent whether or not earlier ones were answered; without one, a client waits for answers.
  client.pace = {.rate_hz = options.rate_hz, .max_in_flight = options.rate_hz > 0 ? 0u : options.in_flight};
  client.deadline = options.deadline;
  client.still = options.still;
  client.reopen = options.reopen;
  client.phase = phase;
  return client;
}

}  // namespace

LoadRun::LoadRun(const LoadOptions& options, const std::vector<LoadGroup>& plan) : options_(options) {
  size_t total = 0;
  for (const auto& group : plan) total += group.clients;
  for (const auto& group : plan) {
    for (size_t i = 0; i < group.clients; ++i) {
      const double phase = static_cast<double>(participants_.size()) / static_cast<double>(total);
      participants_.push_back(
          {group.tenant, std::make_unique<LoadClient>(loop_, client_options(options, group, phase))});
    }
  }
}

Result<void> LoadRun::run(Progress& progress) {
  if (auto connected = connect(progress); !connected) return connected;
  fly(progress);
  land();
  return {};
}

size_t LoadRun::open_clients() const {
  return static_cast<size_t>(
      std::count_if(participants_.begin(), participants_.end(), [](const auto& p) { return p.client->open(); }));
}

Result<void> LoadRun::connect(Progress& progress) {
  const auto all_settled = [this] {
    return std::all_of(participants_.begin(), participants_.end(),
                       [](const auto& p) { return p.client->settled(); });
  };
  while (!loop_.run_until(Clock::now() + kProgressInterval, all_settled)) {
    if (options_.interrupted()) return Error{"interrupted"};
    const TimePoint now = Clock::now();
    if (!progress.due(now)) continue;
    const auto unsettled = std::find_if(participants_.begin(), participants_.end(),
                                        [](const auto& p) { return !p.client->settled(); });
    const std::string& why = unsettled == participants_.end() ? std::string() : unsettled->client->waits_for();
    progress.show(std::to_string(open_clients()) + " of " + std::to_string(participants_.size()) +
                      " clients connected" + (why.empty() ? "" : "; waiting: " + why),
                  now);
  }
  if (open_clients() > 0) return {};
  return participants_.front().client->stream().connection().failure().value_or(Error{"no client connected"});
}

void LoadRun::fly(Progress& progress) {
  const auto first_open =
      std::find_if(participants_.begin(), participants_.end(), [](const auto& p) { return p.client->open(); });
  CameraPath path = CameraPath::orbit(first_open->client->stream().scene());
  if (const auto file = find_scene_file(options_.scene, options_.scene_folder)) {
    if (const auto scene = scenes::load_scene(*file)) path = CameraPath::of_scene(*scene);
  }

  started_ = Clock::now();
  for (auto& p : participants_) p.client->fly(path, started_);
  if (options_.warm_up > Nanoseconds::zero()) {
    fly_until(started_ + options_.warm_up, progress);
    for (auto& p : participants_) p.client->end_warm_up();
    started_ = Clock::now();
  }
  fly_until(started_ + options_.duration, progress);
  for (auto& p : participants_) p.client->stop();
  flight_seconds_ = to_seconds(Clock::now() - started_);
}

void LoadRun::fly_until(TimePoint end, Progress& progress) {
  while (Clock::now() < end && (open_clients() > 0 || options_.reopen) && !options_.interrupted()) {
    loop_.run_until(std::min(end, Clock::now() + kProgressInterval), [] { return false; });
    const TimePoint now = Clock::now();
    if (progress.due(now)) progress.show(progress_line(now), now);
  }
}

void LoadRun::land() {
  Nanoseconds slowest = kLandingTime;
  for (const auto& p : participants_) {
    const Latencies known = p.client->figures().latencies;
    slowest = std::max(slowest, known.count() > 0 ? 2 * known.percentile(1) : kLongestLanding);
  }
  loop_.run_until(Clock::now() + std::min(slowest, kLongestLanding), [this] {
    return std::all_of(participants_.begin(), participants_.end(),
                       [](const auto& p) { return !p.client->open() || p.client->stream().in_flight() == 0; });
  });
  for (auto& p : participants_) p.client->close();
}

std::string LoadRun::progress_line(TimePoint now) const {
  uint64_t frames = 0, lost = 0, invalid = 0;
  for (const auto& p : participants_) {
    const StreamCounters counters = p.client->figures().counters;
    frames += counters.complete;
    lost += counters.lost_slices;
    invalid += counters.invalid_slices;
  }
  const double seconds = to_seconds(now - started_);
  char line[200];
  std::snprintf(line, sizeof line, "%5.1f s  %zu clients  %llu frames (%.1f vbps)  %llu slices lost  %llu invalid",
                seconds, open_clients(), static_cast<unsigned long long>(frames),
                static_cast<double>(frames) / seconds, static_cast<unsigned long long>(lost),
                static_cast<unsigned long long>(invalid));
  return line;
}

}  // namespace gnomon::client
