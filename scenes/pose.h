// Transforms of nodes, and the poses that cameras take from them. Internal to scenes/.
#pragma once

#include <glm/glm.hpp>

#include "scenes/scene.h"

namespace gnomon::scenes {

// The transform from node to parent. A rotation that cannot be normalised counts as none.
glm::dmat4 local_transform(const NodeTransform& node);

// Sets the animated property to its value at `seconds`; before the first key and after the last, the key's value holds.
void apply(const Channel& channel, double seconds, NodeTransform& node);

// Moves a light to a node; the light shines along the node's -Z. Returns false if the node has no direction, because it
// is scaled to 0; the light then keeps its direction.
bool place_light(const glm::dmat4& node_to_world, Light& light);

// The pose of a camera at a transform. Scale, mirroring and shear are dropped: the pose keeps the viewing direction,
// and the part of the up vector that is perpendicular to it.
CameraPose pose_from_transform(const glm::dmat4& camera_to_world, float vertical_fov);

}  // namespace gnomon::scenes
