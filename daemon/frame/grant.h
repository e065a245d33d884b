// What a session was granted: the one value that goes from the handshake to the session's record, the net thread that
// serves it and the device that renders for it. It does not change while the session exists; what is in force at a
// moment (a smaller size, another codec) is a field of its owner.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "common/ids.h"
#include "common/sample_counts.h"
#include "daemon/frame/credential.h"
#include "protocol/types.h"

namespace gnomon::daemon {

// A plain value.
struct SessionGrant {
  TenantId tenant{};
  Credential credential = {};
  std::string scene_name = {};  // as the server names it
  uint16_t width = 0;           // pixels, prediction border included
  uint16_t height = 0;
  float rate_hz = 0;  // 0: no limit
  protocol::CodecId codec = protocol::CodecId::tiles_lz4;
  protocol::CodecId dense_codec = protocol::CodecId::tiles_lz4;  // used while the link is short of bytes
  protocol::CipherId cipher = protocol::CipherId::aes_128_gcm;
  SampleCounts samples = {};
  uint64_t features = 0;  // protocol/types.h: the client's features that this server knows

  // Known once the scene is resident.
  SceneId scene{};
  uint32_t lights = 0;
  std::vector<bool> areas = {};  // for each light, whether it has an extent; if empty, none has

  bool has(uint64_t feature) const { return (features & feature) != 0; }
  bool is_area(uint32_t light) const { return light < areas.size() && areas[light]; }
  uint32_t area_count() const { return static_cast<uint32_t>(std::count(areas.begin(), areas.end(), true)); }
  // Of the session's masks with these samples.
  uint32_t planes(SampleCounts of_samples) const {
    return lights + area_count() * (planes_of(of_samples.per_light) - 1) + planes_of(of_samples.occlusion);
  }
};

}  // namespace gnomon::daemon
