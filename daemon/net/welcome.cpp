#include "daemon/net/welcome.h"

#include <algorithm>

#include "daemon/config/render_effects.h"
#include "gpu/wire/translate.h"

namespace gnomon::daemon {

void complete(SessionGrant& grant, const std::vector<scenes::Light>& lights, SampleCounts most) {
  grant.lights = static_cast<uint32_t>(lights.size());
  for (const scenes::Light& light : lights) grant.areas.push_back(light.area.shape != scenes::LightShape::point);
  grant.samples = fewest(grant.samples, most);
  if (grant.area_count() == 0) grant.samples.per_light = 1;
}

protocol::Welcome welcome_of(const Session& session, const scenes::LoadedScene& scene, const NetShared& shared,
                             ServingPorts ports) {
  const SessionGrant& grant = session.grant();
  protocol::Welcome welcome;
  welcome.features = grant.features;
  welcome.session = session.id();
  welcome.data_port = ports.data;
  welcome.cipher = grant.cipher;
  welcome.width = grant.width;
  welcome.height = grant.height;
  welcome.rate_hz = grant.rate_hz;
  welcome.codec = grant.codec;
  welcome.passes = effects_of(shared.config.render);
  if (grant.samples.per_light == 1) std::erase(welcome.passes, kSoftShadows);
  if (grant.samples.occlusion == Occlusion::none) std::erase(welcome.passes, kAmbientOcclusion);
  welcome.tracer = shared.tracer;
  welcome.silence_timeout_ms = static_cast<uint32_t>(shared.config.server.silence_timeout.count());
  welcome.scene = gpu::manifest_of(*scene.scene, grant.scene_name, float(grant.width) / float(grant.height));
  const LightsUpdate update = shared.scenes.lights_of(grant.scene_name);
  welcome.scene.lights = gpu::to_wire(update.lights);
  welcome.lights_version = update.version;
  welcome.motions = gpu::to_wire(shared.catalog.get()->motions(grant.scene_name));
  if (grant.has(protocol::kFeatureSoft)) {
    welcome.samples = to_byte(grant.samples);
    welcome.areas = gpu::areas_to_wire(update.lights);
  }
  if (grant.has(protocol::kFeatureFleet)) {
    welcome.data_host = welcome.home_host = shared.config.server.public_address;
    welcome.home_port = ports.control;
  }
  return welcome;
}

}  // namespace gnomon::daemon
