// `gnomonctl scene load`: has a scene loaded and shows how far it is.
#pragma once

#include <string>

#include "daemon/ctl/admin_client.h"

namespace gnomon::ctl {

// Blocks until the scene is there or could not be loaded, and shows meanwhile on standard error what the daemon is at.
// Returns the daemon's answer. The error is its refusal, or says that it does not answer.
Result<std::string> load_scene(AdminClient& admin, const std::string& name);

// What /status says of the scene on its way, in one line; empty if it does not.
std::string stage_line(const nlohmann::json& status, const std::string& name);

}  // namespace gnomon::ctl
