#include "protocol/types.h"

#include <algorithm>
#include <cmath>

namespace gnomon::protocol {
namespace {

constexpr float kUnitTolerance = 1e-3f;

bool is_finite(std::initializer_list<float> values) {
  return std::all_of(values.begin(), values.end(), [](float v) { return std::isfinite(v); });
}

template <size_t N>
bool is_finite(const std::array<float, N>& values) {
  return std::all_of(values.begin(), values.end(), [](float v) { return std::isfinite(v); });
}

template <size_t N>
bool is_unit(const std::array<float, N>& v) {
  double squared = 0;
  for (const float component : v) squared += double{component} * component;
  return std::abs(std::sqrt(squared) - 1.0) <= kUnitTolerance;
}

bool is_cosine(float v) { return v >= -1.0f && v <= 1.0f; }

}  // namespace

bool is_known(CodecId codec) { return std::find(kCodecs.begin(), kCodecs.end(), codec) != kCodecs.end(); }

const char* to_string(CodecId codec) {
  switch (codec) {
    case CodecId::raw32_lz4: return "raw32_lz4";
    case CodecId::tiles_lz4: return "tiles_lz4";
    case CodecId::tiles_context: return "tiles_context";
  }
  return "unknown";
}

Result<CodecId> parse_codec(std::string_view name) {
  std::string known;
  for (const CodecId codec : kCodecs) {
    if (name == to_string(codec)) return codec;
    known.append(known.empty() ? "" : ", ").append(to_string(codec));
  }
  return Error{std::string("no codec '").append(name).append("'; there are: ").append(known)};
}

bool is_valid(const CameraView& camera) {
  const float width = camera.tan_left + camera.tan_right;
  const float height = camera.tan_up + camera.tan_down;
  return is_finite(camera.position) && is_finite(camera.orientation) && is_unit(camera.orientation) &&
         is_finite({camera.tan_left, camera.tan_right, camera.tan_up, camera.tan_down, width, height}) &&
         is_finite({camera.near_plane}) && width > 0 && height > 0 && camera.near_plane > 0;
}

bool is_valid(const AreaInfo& area) {
  constexpr uint8_t kShapes = 4;
  return area.shape < kShapes && is_finite(area.u) && is_finite(area.v);
}

bool is_valid(const LightInfo& light) {
  const bool aimed = light.kind != LightKind::point;
  return light.kind <= LightKind::directional && is_finite(light.position) && is_finite(light.direction) &&
         is_finite(light.color) && is_finite({light.intensity, light.range}) && light.intensity >= 0 &&
         light.range >= 0 && is_cosine(light.inner_cone_cos) && is_cosine(light.outer_cone_cos) &&
         (!aimed || is_unit(light.direction));
}

}  // namespace gnomon::protocol
