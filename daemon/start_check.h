// The one check of a configuration: `gnomond --check-config` makes it, the start does before anything else, and a reload.
//
// What is left for the start itself is what only it can find out: that a device opens, has the memory and does what the
// tracer needs, and that nobody else has the ports.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "daemon/config/config.h"
#include "scenes/registry.h"

namespace gnomon::daemon {

struct StartCheckOptions {
  std::filesystem::path config_folder;  // below which relative paths are
  std::filesystem::path share_folder;   // below which scenes are that are not there
  bool for_reload = false;              // leaves out what a daemon that runs has done already: ports, devices
  bool for_start = false;               // a certificate that is not valid yet is no error: time mends it
  scenes::SceneReader read_scene = {};  // reads every configured scene; if empty, as the caller does so itself
  std::function<std::vector<Error>(const Config&)> check_renderers = {};  // of devices, tracer and passes
};

struct StartFindings {
  std::vector<Error> errors;
  std::vector<std::string> warnings;  // what does not keep a daemon from starting
};

// Completes the configuration with what stands in other files: paths are absolute afterwards, and tenants have the hashes
// of their token files. What concerns a key with a mistake of its own (`reading.errors`) is not looked at. Token files
// that cannot be read are added to `reading.errors`, as a reload cannot go on without them: their tokens would look
// revoked. Blocking.
StartFindings check_start(ConfigReading& reading, const StartCheckOptions& options);

}  // namespace gnomon::daemon
