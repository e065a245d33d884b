// Transforms of nodes, and the poses that cameras take from them. Internal to scenes/.
#pragma once

#include <glm/glm.hpp>

#include "scenes/scene.h"

namespace gnomon::scenes {

// Node to parent.
glm::dmat4 local_transform(const NodeTransform& node);

// Scale, mirroring and shear of the transform do not reach the pose: it keeps the looking direction, and the up
// vector as far as it is perpendicular to that.
CameraPose pose_from_transform(const glm::dmat4& camera_to_world, float vertical_fov);

}  // namespace gnomon::scenes
