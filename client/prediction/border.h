// The prediction border (dissertation 3.4): pixels traced around the picture that is shown, so that there are masks for
// what the camera turns to. The focal length in units of the buffer's width shrinks by width / traced width, likewise
// for the height, so that the shown region remains the same.
//
// Beyond the dissertation: more of the border may lie on the side to which the camera turns.
#pragma once

#include <cstdint>

#include "protocol/types.h"
#include "scenes/scene.h"

namespace gnomon::client {

// The picture shown, and the border traced around it (pixels in all, left and right or top and bottom together).
struct ViewSize {
  uint32_t width = 0;
  uint32_t height = 0;
  uint32_t border_x = 0;
  uint32_t border_y = 0;

  uint32_t traced_width() const { return width + border_x; }
  uint32_t traced_height() const { return height + border_y; }
};

// How many of the border's pixels lie left of the picture and above it.
struct BorderPlace {
  uint32_t left = 0;
  uint32_t top = 0;
  friend bool operator==(const BorderPlace&, const BorderPlace&) = default;
};

constexpr BorderPlace centred(const ViewSize& size) { return {size.border_x / 2, size.border_y / 2}; }

// The best place of the border if the camera, now at `now`, is at `then` when the masks are used. Only the turn counts.
BorderPlace towards(const ViewSize& size, const scenes::CameraPose& now, const scenes::CameraPose& then);

// The pose after `now` if the camera continues to turn and move as from `before` to `now`, for `steps` times as long.
scenes::CameraPose extrapolate(const scenes::CameraPose& before, const scenes::CameraPose& now, float steps);

// The camera of the traced buffer, whose frustum includes the border.
protocol::CameraView view_of(const scenes::CameraPose& pose, const ViewSize& size, BorderPlace place);
protocol::CameraView view_of(const scenes::CameraPose& pose, const ViewSize& size);  // centred

// The inverse: where the border of such a camera lies, and the camera of the shown picture alone.
BorderPlace place_of(const protocol::CameraView& traced, const ViewSize& size);
protocol::CameraView shown_part(const protocol::CameraView& traced, const ViewSize& size);

}  // namespace gnomon::client
