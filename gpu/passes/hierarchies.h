// The hierarchies of a frame, as shaders/tracers/bvh.glsl reads them.
#pragma once

#include <algorithm>
#include <cstring>
#include <initializer_list>
#include <vector>

#include "gpu/passes/pass.h"

namespace gnomon::gpu {

struct Hierarchy {
  VkDeviceAddress nodes = 0;
  VkDeviceAddress triangles = 0;
  uint32_t node_count = 0;
  uint32_t first_triangle = 0;
};

// Empty if the frame has none.
inline Hierarchy resting_hierarchy(const PosedScene& posed) {
  Hierarchy still;
  if (!posed.static_bvh) return still;
  const std::span<const std::byte> bytes = posed.static_bvh->push_constants();
  std::memcpy(&still, bytes.data(), std::min(bytes.size(), sizeof(still)));
  return still;
}

// Of the resource moving_bvh, as gpu/passes/pose.cpp lays it out.
inline Hierarchy moving_hierarchy(const FrameContext& frame, const Buffer& moving_bvh) {
  const uint64_t most_nodes = 2 * uint64_t{frame.scene.moving_size().triangles};
  return {moving_bvh.address(), moving_bvh.address() + most_nodes * sizeof(BvhNode),
          static_cast<uint32_t>(frame.posed.bvh.nodes.size()), frame.scene.moving_place(frame.slot).first_triangle};
}

// How many buffers each set of texels has that such a pass binds (shaders/texels.glsl): none where the device loads no
// texels. `behind`: of sets behind those of the hierarchies.
inline std::vector<uint32_t> texel_sets(const Device& device, std::initializer_list<uint32_t> behind = {}) {
  std::vector<uint32_t> sets;
  if (!device.features().loads_texels()) return sets;
  sets = {1, 1, 1};
  sets.insert(sets.end(), behind);
  return sets;
}

// A frame's sets, likewise. `moving`: the port of moving_bvh; nullptr where nothing moves, and its hierarchy is empty.
inline std::vector<VkDescriptorSet> texels_of(const FrameContext& frame, const BoundPort* moving,
                                              std::initializer_list<VkDescriptorSet> behind = {}) {
  std::vector<VkDescriptorSet> sets;
  if (frame.scene.texels() == VK_NULL_HANDLE) return sets;
  const VkDescriptorSet resting = frame.posed.static_bvh->texels();
  sets = {frame.scene.texels(), resting, moving ? moving->texels : resting};
  sets.insert(sets.end(), behind);
  return sets;
}

inline VkDeviceAddress moving_parts(const FrameContext& frame, const Buffer& moving_bvh) {
  return moving_hierarchy(frame, moving_bvh).triangles +
         uint64_t{frame.scene.moving_size().triangles} * sizeof(BvhTriangle);
}

}  // namespace gnomon::gpu
