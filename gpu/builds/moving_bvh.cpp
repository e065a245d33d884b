#include "gpu/builds/moving_bvh.h"

#include <algorithm>

namespace gnomon::gpu {
namespace {

constexpr double kLoosest = 4.0 / 3.0;  // in units of the looseness as built

double half_area(const glm::vec3& lo, const glm::vec3& hi) {
  const glm::dvec3 d = glm::dvec3(hi) - glm::dvec3(lo);
  return d.x * d.y + d.y * d.z + d.z * d.x;
}

void place(const scenes::WorldMesh& mesh, BvhTriangle& triangle) {
  const glm::uvec3 corners = mesh.triangles[triangle.triangle];
  triangle.p0 = mesh.positions[corners.x];
  triangle.p1 = mesh.positions[corners.y];
  triangle.p2 = mesh.positions[corners.z];
  triangle.masked = triangle.triangle >= mesh.opaque_count ? 1 : 0;
}

void fit_leaf(const std::vector<BvhTriangle>& triangles, BvhNode& leaf) {
  const BvhTriangle* triangle = &triangles[leaf.leaf >> 4];
  leaf.lo = leaf.hi = triangle->p0;
  for (const BvhTriangle* end = triangle + (leaf.leaf & 15); triangle < end; ++triangle) {
    leaf.lo = glm::min(glm::min(leaf.lo, triangle->p0), glm::min(triangle->p1, triangle->p2));
    leaf.hi = glm::max(glm::max(leaf.hi, triangle->p0), glm::max(triangle->p1, triangle->p2));
  }
}

// From the last node to the first, as children follow their parents.
void fit(const scenes::WorldMesh& mesh, Bvh& bvh) {
  for (BvhTriangle& triangle : bvh.triangles) place(mesh, triangle);
  for (size_t n = bvh.nodes.size(); n-- > 0;) {
    BvhNode& node = bvh.nodes[n];
    if (node.leaf != 0) {
      fit_leaf(bvh.triangles, node);
      continue;
    }
    const BvhNode& left = bvh.nodes[n + 1];
    const BvhNode& right = bvh.nodes[left.skip];
    node.lo = glm::min(left.lo, right.lo);
    node.hi = glm::max(left.hi, right.hi);
  }
}

// What rays are expected to visit, by the areas of the nodes' boxes, in units of the areas of the triangles' own ones: how
// the tree groups the triangles changes it, but not how large they are.
double looseness(const Bvh& bvh) {
  double nodes = 0, triangles = 0;
  for (const BvhNode& node : bvh.nodes) nodes += half_area(node.lo, node.hi) * (1.0 + (node.leaf & 15));
  for (const BvhTriangle& t : bvh.triangles)
    triangles += half_area(glm::min(glm::min(t.p0, t.p1), t.p2), glm::max(glm::max(t.p0, t.p1), t.p2));
  return triangles > 0 ? nodes / triangles : 0;
}

bool is_leaf(const BvhPart& part) { return part.end == part.first + 1; }

}  // namespace

const Bvh& MovingBvh::follow(const scenes::WorldMesh& mesh) {
  if (builds_ > 0 && bvh_.triangles.size() == mesh.triangles.size()) {
    fit(mesh, bvh_);
    if (looseness(bvh_) <= kLoosest * built_looseness_) return bvh_;
  }
  bvh_ = build_bvh(mesh, 1);
  built_looseness_ = looseness(bvh_);
  ++builds_;
  return bvh_;
}

std::vector<BvhPart> parts_of(const Bvh& bvh) {
  std::vector<BvhPart> parts;
  const auto part_at = [&](uint32_t n) {
    const BvhNode& node = bvh.nodes[n];
    return BvhPart{node.lo, n, node.hi, node.skip};
  };
  if (!bvh.nodes.empty()) parts.push_back(part_at(0));
  const auto size = [](const BvhPart& part) { return is_leaf(part) ? -1.0 : half_area(part.lo, part.hi); };
  while (!parts.empty() && parts.size() < kMostParts) {
    const auto largest = std::ranges::max_element(parts, {}, size);
    if (is_leaf(*largest)) break;
    const BvhPart left = part_at(largest->first + 1), right = part_at(left.end);
    *largest = left;
    parts.push_back(right);
  }
  return parts;
}

}  // namespace gnomon::gpu
