// A bounding volume hierarchy, as push constants have it (gpu/passes/hierarchies.h). Nodes and triangles lie in one buffer.
#ifndef HIERARCHY_GLSL
#define HIERARCHY_GLSL
struct Hierarchy {
  uvec2 nodes;
  uvec2 triangles;
  uint node_count;
  uint first_triangle;  // added to the numbers of its triangles
};
#endif
