// Random scenes made to break light buffers, a few to a few hundred triangles and one light.
#pragma once

#include <array>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "gpu/exact_cpp.h"
#include "scenes/world_mesh.h"

namespace gnomon::test {

using Random = std::mt19937;

struct Soup {
  scenes::WorldMesh mesh;
  scenes::Bounds bounds;
  gpu::exact::TracedLight light;
};

enum class Shape {
  even,      // triangles of about the same size
  tiny,      // far smaller than a node of any level
  huge,      // larger than the scene's middle, seen at all angles
  slivers,   // up to a million times longer than wide
  edge_on,   // in planes through the light, exactly or but for an ulp
  touching,  // with a corner, an edge or the inside at the light
  sheets,    // closed boxes and walls that share edges: covers and shared edges
  astride,   // from before the light to behind it, over the borders of its faces, near and far
  around,    // closed boxes about the light, with a hole here and there
  grid,      // all on a coarse lattice, the light too: ties everywhere
};

enum class Lamp { point, spot, directional };

std::string name(Shape shape);
std::string name(Lamp lamp);

Soup make_soup(Shape shape, Lamp lamp, int triangles, Random& random);

// A surface point on or near one of the soup's triangles, or anywhere, with a normal that faces the light.
gpu::exact::SurfacePoint make_point(const Soup& soup, Random& random);

// Whether some triangle meets the segment: brute force, by the shared test.
bool blocked(const scenes::WorldMesh& mesh, const gpu::exact::ShadowSegment& segment);

}  // namespace gnomon::test
