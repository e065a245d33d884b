// Converts between the types of the scene and the GPU and those of the wire. Only the daemon knows both.
#pragma once

#include <string>

#include "gpu/renderer.h"
#include "protocol/types.h"
#include "scenes/scene.h"

namespace gnomon::daemon {

gpu::CameraView to_gpu(const protocol::CameraView& camera);

std::vector<protocol::LightInfo> to_wire(const std::vector<scenes::Light>& lights);

std::vector<protocol::NodeMotion> to_wire(const std::vector<scenes::NodeMotion>& motions);

// `aspect`: width over height of the client's buffer, for the default camera's frustum.
protocol::SceneManifest manifest_of(const scenes::Scene& scene, const std::string& name, float aspect);

}  // namespace gnomon::daemon
