#include "client/prediction/border.h"

#include <algorithm>
#include <cmath>

namespace gnomon::client {
namespace {

// The border's pixels left of the picture (or above) if what is wanted lies `shift` pixels to the right (or down).
uint32_t before(uint32_t border, float shift) {
  const float wanted = static_cast<float>(border) / 2 - shift;
  return static_cast<uint32_t>(std::clamp(std::lround(wanted), 0l, static_cast<long>(border)));
}

struct Pixel {
  float width, height;  // in tangents
};

Pixel pixel_of(const protocol::CameraView& traced, const ViewSize& size) {
  return {(traced.tan_left + traced.tan_right) / static_cast<float>(size.traced_width()),
          (traced.tan_up + traced.tan_down) / static_cast<float>(size.traced_height())};
}

}  // namespace

BorderPlace towards(const ViewSize& size, const scenes::CameraPose& now, const scenes::CameraPose& then) {
  const glm::vec3 forward = glm::inverse(now.orientation) * (then.orientation * glm::vec3(0, 0, -1));
  if (forward.z > -0.1f) return centred(size);  // it turns away completely: no border helps
  const float per_tangent = static_cast<float>(size.height) / (2 * std::tan(now.vertical_fov / 2));
  return {before(size.border_x, per_tangent * forward.x / -forward.z),
          before(size.border_y, per_tangent * forward.y / forward.z)};
}

scenes::CameraPose extrapolate(const scenes::CameraPose& before, const scenes::CameraPose& now, float steps) {
  scenes::CameraPose then = now;
  then.position += steps * (now.position - before.position);
  glm::quat turn = now.orientation * glm::inverse(before.orientation);
  if (turn.w < 0) turn = -turn;
  const glm::vec3 axis(turn.x, turn.y,
                       turn.z);  // glm::axis() divides by what is left of 1 - w^2: nothing, of small turns
  const float size = glm::length(axis);
  const float angle = 2 * std::atan2(size, turn.w);
  if (angle > 1e-6f) then.orientation = glm::angleAxis(steps * angle, axis / size) * now.orientation;
  return then;
}

protocol::CameraView view_of(const scenes::CameraPose& pose, const ViewSize& size, BorderPlace place) {
  const float shown_up = std::tan(pose.vertical_fov / 2);
  const float shown_right = shown_up * static_cast<float>(size.width) / static_cast<float>(size.height);
  const float across = 2 * shown_right / static_cast<float>(size.width);  // tangent per pixel
  const float down = 2 * shown_up / static_cast<float>(size.height);
  const glm::quat q = glm::normalize(pose.orientation);
  protocol::CameraView view;
  view.position = {pose.position.x, pose.position.y, pose.position.z};
  view.orientation = {q.x, q.y, q.z, q.w};
  view.tan_left = shown_right + across * static_cast<float>(place.left);
  view.tan_right = shown_right + across * static_cast<float>(size.border_x - place.left);
  view.tan_up = shown_up + down * static_cast<float>(place.top);
  view.tan_down = shown_up + down * static_cast<float>(size.border_y - place.top);
  return view;
}

protocol::CameraView view_of(const scenes::CameraPose& pose, const ViewSize& size) {
  // Exactly symmetric, even if the border's size is odd.
  protocol::CameraView view = view_of(pose, size, centred(size));
  view.tan_left = view.tan_right = (view.tan_left + view.tan_right) / 2;
  view.tan_up = view.tan_down = (view.tan_up + view.tan_down) / 2;
  return view;
}

BorderPlace place_of(const protocol::CameraView& traced, const ViewSize& size) {
  const Pixel pixel = pixel_of(traced, size);
  const auto part = [](uint32_t border, float skew) { return before(border, -skew / 2); };
  return {part(size.border_x, (traced.tan_left - traced.tan_right) / pixel.width),
          part(size.border_y, (traced.tan_up - traced.tan_down) / pixel.height)};
}

protocol::CameraView shown_part(const protocol::CameraView& traced, const ViewSize& size) {
  const Pixel pixel = pixel_of(traced, size);
  const BorderPlace place = place_of(traced, size);
  protocol::CameraView shown = traced;
  shown.tan_left -= pixel.width * static_cast<float>(place.left);
  shown.tan_right -= pixel.width * static_cast<float>(size.border_x - place.left);
  shown.tan_up -= pixel.height * static_cast<float>(place.top);
  shown.tan_down -= pixel.height * static_cast<float>(size.border_y - place.top);
  return shown;
}

}  // namespace gnomon::client
