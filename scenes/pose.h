// Transforms of nodes, and the poses that cameras take from them. Internal to scenes/.
#pragma once

#include <glm/glm.hpp>

#include "scenes/scene.h"

namespace gnomon::scenes {

// Node to parent.
glm::dmat4 local_transform(const NodeTransform& node);

// Sets the animated property to its value at `seconds`, held before the first key and after the last.
void apply(const Channel& channel, double seconds, NodeTransform& node);

// Puts a light where a node is: it shines along the node's -Z. False: the node is scaled to nothing and has no
// direction, which the light then keeps.
bool place_light(const glm::dmat4& node_to_world, Light& light);

// Scale, mirroring and shear of the transform do not reach the pose: it keeps the looking direction, and the up
// vector as far as it is perpendicular to that.
CameraPose pose_from_transform(const glm::dmat4& camera_to_world, float vertical_fov);

}  // namespace gnomon::scenes
