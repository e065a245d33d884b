// Connects the clients of a plan, has them all fly for a while and collects their figures.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "client/cli/options.h"
#include "client/load/load_client.h"
#include "client/load/load_plan.h"
#include "common/progress.h"

namespace gnomon::client {

struct LoadOptions {
  Address server;
  Trust trust = {};
  Transport transport = Transport::automatic;
  std::string scene;
  std::filesystem::path scene_folder;  // where the scene's own file may be, for its camera path; may be empty
  Size size;
  std::vector<protocol::CodecId> codecs = {};  // that clients list; if empty, the server's choice
  SampleCounts samples = {};                   // wanted at most
  double rate_hz = 0;                          // 0: each client asks again as soon as it has been answered
  bool still = false;                          // each client asks for one frame, then stands still
  bool reopen = false;                         // a session that is lost during the flight is opened again
  uint32_t in_flight = 1;                      // cameras that a client without a rate may have unanswered
  Nanoseconds deadline{};                      // how long after its camera an answer is useful; 0: not said
  Nanoseconds warm_up{};                       // flown before the duration, and not measured
  Nanoseconds duration = std::chrono::seconds(10);
  std::function<bool()> interrupted = [] { return false; };  // asked a few times a second; true ends the flight
};

struct LoadParticipant {
  std::string tenant;
  std::unique_ptr<LoadClient> client;
};

// One thread; it owns its loop.
class LoadRun {
 public:
  LoadRun(const LoadOptions& options, const std::vector<LoadGroup>& plan);

  // Blocks. Error if no client could connect (the first one's reason) or the run was interrupted before the flight.
  Result<void> run(Progress& progress);

  const std::vector<LoadParticipant>& participants() const { return participants_; }
  double flight_seconds() const { return flight_seconds_; }  // measured
  size_t open_clients() const;

 private:
  Result<void> connect(Progress& progress);
  void fly(Progress& progress);
  void fly_until(TimePoint end, Progress& progress);
  void land();
  std::string progress_line(TimePoint now) const;

  LoadOptions options_;
  Loop loop_;
  std::vector<LoadParticipant> participants_;
  TimePoint started_{};
  double flight_seconds_ = 0;
};

}  // namespace gnomon::client
