// What stands behind a gnomon_client: a loop of its own, the thin client on it, and what the server has told. It shows
// nothing and predicts nothing, as that is the engine's.
//
// One thread at a time.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "client/net/loop.h"
#include "client/thin_client.h"

namespace gnomon::client::c {

// Of the server met last. A later session, or a resumed one, begins anew.
struct Told {
  uint32_t revision = 0;  // counts what has changed of the scene, its lights and motions
  protocol::Welcome welcome;
  protocol::SceneManifest scene;
  uint32_t lights_version = 0;
  uint32_t width = 0, height = 0;  // of masks now
  float rate_hz = 0;
  std::string degraded;  // why these are less than granted; empty if they are not
  uint32_t draining_ms = 0;
  protocol::Stats stats;
};

class EngineSession {
 public:
  enum class State { connecting, open, lost, failed, closed };

  explicit EngineSession(ThinClientOptions options);  // begins to connect

  State state() const;
  const ThinClient& client() const { return client_; }
  const Told& told() const { return told_; }

  // Serves the network until `done` or for so long; 0: what is there to be done without waiting.
  void serve(uint32_t timeout_ms, const std::function<bool()>& done);

  // While open. The camera's index.
  uint32_t look(const protocol::CameraView& camera);

  // The newest masks, once. Null: none have come since.
  std::shared_ptr<const Received> next();
  uint64_t given() const { return given_; }

  void close(const std::string& reason);

 private:
  void learn();
  void on_message(const protocol::Message& message);
  void on_degraded(const protocol::Degraded& degraded);

  Loop loop_;
  bool closed_ = false;
  uint32_t looked_ = 0;
  uint64_t given_ = 0;
  uint64_t opened_ = 0;  // sessions opened and resumed, as far as `told_` knows
  Told told_;
  ThinClient client_;
};

}  // namespace gnomon::client::c
