// The hierarchy over geometry that moves: fitted to each pose, and built anew only where that would be too loose.
#pragma once

#include <optional>
#include <vector>

#include "gpu/builds/bvh.h"

namespace gnomon::gpu {

// Follows a mesh from pose to pose. One thread.
//
// The boxes of the last pose's tree are fitted to the new corners; once they have grown by a third more than their
// triangles, the tree is built anew (Lauterbach et al., "RT-DEFORM: Interactive Ray Tracing of Dynamic Scenes using
// BVHs", 2006). Either way a box holds all of its triangles, so that what is traced does not depend on it.
class MovingBvh {
 public:
  // The hierarchy over `mesh`, with its triangles numbered as there.
  const Bvh& follow(const scenes::WorldMesh& mesh);

  uint64_t builds() const { return builds_; }  // the others of follow() were fitted

 private:
  Bvh bvh_;
  double built_looseness_ = 0;
  uint64_t builds_ = 0;
};

// A subtree, as shaders/trace_moving.comp reads it: nodes `first` to `end` - 1.
struct BvhPart {
  glm::vec3 lo{0.0f};
  uint32_t first = 0;
  glm::vec3 hi{0.0f};
  uint32_t end = 0;
};
static_assert(sizeof(BvhPart) == 32);

inline constexpr size_t kMostParts = 32;

// Disjoint subtrees that hold all triangles: of those that are not leaves, the one with the largest box is divided until
// there are kMostParts.
std::vector<BvhPart> parts_of(const Bvh& bvh);

}  // namespace gnomon::gpu
