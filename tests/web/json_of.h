// Cameras and lights of WIRE.md as the page's modules have them.
#pragma once

#include <nlohmann/json.hpp>

#include "protocol/types.h"

namespace gnomon {

inline nlohmann::json json_of(const protocol::CameraView& c) {
  return {
      {"position", c.position}, {"orientation", c.orientation}, {"tanLeft", c.tan_left}, {"tanRight", c.tan_right},
      {"tanUp", c.tan_up},      {"tanDown", c.tan_down},        {"near", c.near_plane}};
}

inline nlohmann::json json_of(const protocol::LightInfo& l) {
  return {{"kind", static_cast<int>(l.kind)}, {"position", l.position},
          {"direction", l.direction},         {"color", l.color},
          {"intensity", l.intensity},         {"range", l.range},
          {"innerConeCos", l.inner_cone_cos}, {"outerConeCos", l.outer_cone_cos}};
}

}  // namespace gnomon
