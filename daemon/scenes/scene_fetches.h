// Scenes that are waited for.
#pragma once

#include <future>
#include <optional>
#include <string>
#include <vector>

#include "daemon/scenes/scene_host.h"

namespace gnomon::daemon {

// As SceneHost::fetch(), for a caller that waits for the result: a success when the scene is resident, or the error.
// Precondition: the render threads run.
using SceneFetches = std::vector<std::future<Result<void>>>;
std::future<Result<void>> fetch_later(SceneHost& host, const std::string& name);

// The one of this name; nullopt if it is not under way. Any thread.
std::optional<SceneUnderWay> under_way(const SceneHost& host, const std::string& name);

}  // namespace gnomon::daemon
