// One root node's quadtree, built top down.
#pragma once

#include <cstdint>
#include <vector>

#include "gpu/tracers/light_buffer/bounds.h"
#include "gpu/tracers/light_buffer/light_buffer.h"

namespace gnomon::gpu::light_buffer {

struct Detail {
  double longest_walk = 2.0;  // nodes where more triangles are tested, on average, are divided
  uint32_t usual_level = 8;   // beyond, each level must promise twice as much
  uint32_t finest_level = kFinestLevel;
};

// Node 0 is the root; children and lists are indices into these arrays.
struct Subtree {
  std::vector<Node> nodes;
  std::vector<uint32_t> lists;
};

// `met`: the footprints that may meet root (i, j).
Subtree build_subtree(const Face& face, const Detail& detail, uint32_t i, uint32_t j,
                      std::vector<const Footprint*> met);

}  // namespace gnomon::gpu::light_buffer
