#include "protocol/context/camera_motion.h"

#include <algorithm>
#include <cmath>

namespace gnomon::protocol::context {
namespace {

Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
// v + factor * w.
Vec3 sum(const Vec3& v, float factor, const Vec3& w) {
  return {v[0] + factor * w[0], v[1] + factor * w[1], v[2] + factor * w[2]};
}
Vec3 rotated(const Quat& q, const Vec3& v) {
  const Vec3 axis{q[0], q[1], q[2]}, side = cross(axis, v);
  return sum(sum(v, 2 * q[3], side), 2, cross(axis, side));
}
Quat inverse(const Quat& q) { return {-q[0], -q[1], -q[2], q[3]}; }

}  // namespace

CameraMotion::CameraMotion(const CameraView& now, const CameraView& before, const TileGrid& grid) {
  const auto width = static_cast<float>(grid.width), height = static_cast<float>(grid.height);
  const auto turned = [&](const Vec3& v) {
    return rotated(inverse(before.orientation), rotated(now.orientation, v));
  };
  right_down_out_ = {turned({(now.tan_left + now.tan_right) / width, 0, 0}),
                     turned({0, -(now.tan_up + now.tan_down) / height, 0}),
                     turned({-now.tan_left, now.tan_up, -1})};
  step_ = rotated(inverse(before.orientation), sum(now.position, -1, before.position));
  scale_x_ = width / (before.tan_left + before.tan_right);
  scale_y_ = height / (before.tan_up + before.tan_down);
  origin_x_ = before.tan_left * scale_x_;
  origin_y_ = before.tan_up * scale_y_;
}

CameraMotion::Place CameraMotion::place(float x, float y, float nearness) const {
  const auto& [right, down, out] = right_down_out_;
  const Vec3 there = sum(sum(sum(out, x, right), y, down), nearness, step_);
  return {origin_x_ - scale_x_ * there[0] / there[2], origin_y_ + scale_y_ * there[1] / there[2], there[2]};
}

std::optional<Motion> CameraMotion::at(float x, float y, float nearness) const {
  constexpr float kBehind = -0.01f;
  const Place there = place(x, y, nearness);
  const float dx = there.x - x, dy = there.y - y;
  if (!(there.z < kBehind && std::abs(dx) <= kMostMotion && std::abs(dy) <= kMostMotion)) return std::nullopt;
  return Motion{static_cast<int>(std::lround(dx)), static_cast<int>(std::lround(dy))};
}

float CameraMotion::nearness_step(float x, float y, float pixels) const {
  constexpr float kLittle = 1e-3f;
  const Place far = place(x, y, 0), nearer = place(x, y, kLittle);
  const float moved = std::hypot(nearer.x - far.x, nearer.y - far.y);
  return pixels * kLittle / std::max(moved, 1e-9f);
}

}  // namespace gnomon::protocol::context
