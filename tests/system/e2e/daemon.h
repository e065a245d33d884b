// The real gnomond on free loopback ports, and what its admin pages say.
#pragma once

#include <map>
#include <string>

#include "client/net/address.h"
#include "tests/system/e2e/process.h"

namespace gnomon::tests {

// The living room, two tenants, little patience with the silent. What is measured does not change while light buffers
// are built.
inline constexpr const char* kConfig = R"(
server: {mode: demo, state_folder: state, listen: 127.0.0.1, control_port: 0, data_port: 0, silence_timeout_ms: 3000, drain_timeout_ms: 2000}
admin: {listen: 127.0.0.1, port: 0}
render: {device: cpu, wait_for_light_buffers: true}
scenes:
  list:
    - {name: living_room, file: living_room.glb}
tenants:
  - {name: studio}
  - {name: arcade}
)";

std::filesystem::path living_room_file();

// Where daemons keep the light buffers that they have built, for others of the same build, or the folder that the
// environment's GNOMON_TEST_LIGHT_BUFFERS names; a configuration that names a `cache_folder` has its own.
std::filesystem::path kept_light_buffers();

class Daemon {
 public:
  // Returns once it serves (or has failed: then address() has port 0, and output() says why).
  explicit Daemon(const std::string& config = kConfig);

  const client::Address& address() const { return control_; }
  std::string server() const { return to_string(control_); }
  const std::string& pin() const { return pin_; }  // of its certificate
  uint16_t data_port() const { return data_port_; }
  Process& process() { return process_; }
  void rewrite_config(const std::string& text) const;  // in the place of what it was started with

  // Body of an admin page; empty when the server does not answer.
  std::string page(const std::string& path) const;
  // Status line of the answer to a JSON body, through the operators' socket.
  std::string post(const std::string& path, const std::string& json) const;
  // Sum of a metric's series whose labels contain all of `labels` (as `tenant="studio"`); counts series too.
  double metric(const std::string& name, const std::vector<std::string>& labels = {}) const;
  double sessions() const { return metric("gnomon_sessions"); }

 private:
  TemporaryFolder folder_;
  Process process_;
  client::Address control_;
  client::Address admin_;
  uint16_t data_port_ = 0;
  std::string pin_;
};

}  // namespace gnomon::tests
