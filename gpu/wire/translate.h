// Cameras, lights and scenes as the protocol has them, from those of scenes/ and the renderer, and back. For whoever
// speaks the protocol and renders: the daemon, and clients that draw by themselves. Pure.
#pragma once

#include <string>
#include <vector>

#include "gpu/renderer.h"
#include "protocol/types.h"
#include "scenes/scene.h"

namespace gnomon::gpu {

CameraView from_wire(const protocol::CameraView& camera);
protocol::CameraView to_wire(const CameraView& camera);

// The light has no name. `info` has been checked by the protocol's decoder.
scenes::Light from_wire(const protocol::LightInfo& info);
std::vector<protocol::LightInfo> to_wire(const std::vector<scenes::Light>& lights);

std::vector<protocol::AreaInfo> areas_to_wire(const std::vector<scenes::Light>& lights);

std::vector<protocol::NodeMotion> to_wire(const std::vector<scenes::NodeMotion>& motions);

// `aspect`: width over height of the client's buffer, for the default camera's frustum.
protocol::SceneManifest manifest_of(const scenes::Scene& scene, const std::string& name, float aspect);

}  // namespace gnomon::gpu
