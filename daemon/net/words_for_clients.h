// What clients are told in words of the state of other parts.
#pragma once

#include <optional>
#include <string>

#include "daemon/metrics/health.h"
#include "daemon/scenes/scene_catalog.h"
#include "daemon/scenes/scene_host.h"
#include "protocol/messages.h"

namespace gnomon::daemon {

// Who asks for a scene that is not here is told of those that are; other refusals stay as they are.
protocol::Refused with_scenes(protocol::Refused refused, const SceneCatalog& catalog);

// Why a scene is not served, without the scene's folder, whose name is no client's business.
std::string without_folder(std::string why, const std::string& scene, const SceneCatalog& catalog);

// What a client waits for whose scene is on its way, or not. In words that name neither the scene's file nor other clients.
protocol::Waiting what_is_waited_for(const Health& health, const std::optional<SceneUnderWay>& scene);

}  // namespace gnomon::daemon
