// The implementation of a gnomon_client: a loop of its own, the thin client on it, and what the server has reported. It
// neither shows nor predicts, which is the engine's part.
//
// One thread at a time.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "client/net/loop.h"
#include "client/thin_client.h"

namespace gnomon::client::c {

// What the server has reported in the newest session, since that was opened or resumed last.
struct ServerState {
  uint32_t revision = 0;  // counts changes of the scene, its lights and motions
  protocol::Welcome welcome;
  protocol::SceneManifest scene;
  uint32_t lights_version = 0;
  uint32_t width = 0, height = 0;  // of masks from now on
  float rate_hz = 0;
  std::string degraded;  // why these are less than granted; empty if they are not
  uint32_t draining_ms = 0;
  SampleCounts samples;
  protocol::Stats stats;
};

class EngineSession {
 public:
  enum class State { connecting, open, lost, failed, closed };

  explicit EngineSession(ThinClientOptions options);  // begins to connect

  State state() const;
  const ThinClient& client() const { return client_; }
  const ServerState& server() const { return server_; }

  // Serves the network until `done` returns true or `timeout_ms` has passed; 0: serves what is ready, without waiting.
  void serve(uint32_t timeout_ms, const std::function<bool()>& done);

  // Sends a camera and returns its index. Precondition: the session is open.
  uint32_t look(const protocol::CameraView& camera);

  // The newest masks; nullptr if none have arrived since the last call.
  std::shared_ptr<const ReceivedMasks> next();
  uint64_t given() const { return given_; }  // masks that next() has returned

  void close(const std::string& reason);

 private:
  void learn();
  void on_message(const protocol::Message& message);
  void on_degraded(const protocol::Degraded& degraded);

  Loop loop_;
  bool closed_ = false;
  uint32_t looked_ = 0;
  uint64_t given_ = 0;
  uint64_t opened_ = 0;  // how often a session was opened or resumed, as of `server_`
  ServerState server_;
  ThinClient client_;
};

}  // namespace gnomon::client::c
