#include "gpu/tracers/light_buffer/subdivide.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

namespace gnomon::gpu::light_buffer {
namespace {

using Met = std::vector<const Footprint*>;

class Builder {
 public:
  Builder(const Face& face, const Detail& detail, Subtree& out) : face_(face), detail_(detail), out_(out) {}

  void build(uint32_t node, uint32_t level, uint32_t i, uint32_t j, Met& met) {
    const Rect rect = face_.node_rect(level, i, j);
    drop_hidden(node, rect, met);
    const Linear near = set_near_plane(node, rect, met);
    const bool fine = met.size() <= 2 || level >= detail_.finest_level || walk(rect, met, near) <= patience(level);
    if (fine || !divide(node, level, i, j, met)) set_list(node, rect, met);
  }

 private:
  void drop_hidden(uint32_t node, const Rect& rect, Met& met) {
    const Footprint* cover = find_cover(met, rect);
    glm::vec3 plane(0.0f);
    if (cover != nullptr && face_.plane(cover->cover, -1.0, plane)) {
      std::erase_if(met, [&](const Footprint* f) { return hidden(*f, *cover, rect); });
    }
    out_.nodes[node].cover_plane = plane;
  }

  Linear set_near_plane(uint32_t node, const Rect& rect, const Met& met) {
    // No plane: never in front of it, at any depth that a float can hold.
    glm::vec3 plane = met.empty() ? glm::vec3(0.0f) : glm::vec3(face_.depth_axis * 1e30);
    Linear nearness(0, 0, 1e30);
    if (!met.empty() && fit_near_plane(met, rect, nearness)) {
      glm::vec3 fitted;
      if (face_.plane(nearness, 1.0, fitted) || face_.plane(Linear(0, 0, nearest_of_all(rect, met)), 1.0, fitted)) {
        plane = fitted;
      }
    }
    out_.nodes[node].near_plane = plane;
    return nearness;
  }

  // Fine nodes are many and seen by few pixels: they are divided further only for long lists.
  double patience(uint32_t level) const {
    return level <= detail_.usual_level
               ? detail_.longest_walk
               : std::ldexp(detail_.longest_walk, static_cast<int>(level - detail_.usual_level));
  }

  // Triangles tested for a point on one of the footprints, on average over them: none where it lies on the near
  // plane, else those before it. What is seen in a scene is mostly what casts its shadows.
  static double walk(const Rect& rect, const Met& met, const Linear& near) {
    size_t walking = 0;
    for (const Footprint* f : met) {
      const double u = std::clamp(0.5 * (rect.u0 + rect.u1), f->box.u0, f->box.u1);
      const double v = std::clamp(0.5 * (rect.v0 + rect.v1), f->box.v0, f->box.v1);
      const double bound = at(near, u, v);
      if (!f->bounded || at(f->nearest, u, v) < bound - 0.003 * std::abs(bound)) ++walking;
    }
    return 0.5 * static_cast<double>(walking);
  }

  static double nearest_of_all(const Rect& rect, const Met& met) {
    double nearest = nearest_in(*met.front(), rect);
    for (const Footprint* f : met) nearest = std::max(nearest, nearest_in(*f, rect));
    return nearest;
  }

  // False where dividing would not shorten the lists.
  bool divide(uint32_t node, uint32_t level, uint32_t i, uint32_t j, const Met& met) {
    std::array<Met, 4> child;
    size_t total = 0;
    for (uint32_t c = 0; c < 4; ++c) {
      const Rect rect = face_.node_rect(level + 1, 2 * i + (c & 1), 2 * j + (c >> 1));
      for (const Footprint* f : met) {
        if (meets(*f, rect)) child[c].push_back(f);
      }
      total += child[c].size();
    }
    if (10 * total > 36 * met.size() && met.size() < 64) return false;
    const uint32_t first = static_cast<uint32_t>(out_.nodes.size());
    out_.nodes.resize(first + 4, Node{});
    out_.nodes[node].children = first;
    out_.nodes[node].list = kNone;
    for (uint32_t c = 0; c < 4; ++c) {
      build(first + c, level + 1, 2 * i + (c & 1), 2 * j + (c >> 1), child[c]);
    }
    return true;
  }

  void set_list(uint32_t node, const Rect& rect, const Met& met) {
    std::vector<ListEntry> entries;
    entries.reserve(met.size());
    for (const Footprint* f : met) {
      entries.push_back({f->triangle, face_.reciprocal_depth(nearest_in(*f, rect))});
    }
    std::sort(entries.begin(), entries.end(), [](const ListEntry& a, const ListEntry& b) {
      return a.reciprocal_depth != b.reciprocal_depth ? a.reciprocal_depth > b.reciprocal_depth
                                                      : a.triangle < b.triangle;
    });
    out_.nodes[node].children = kNone;
    out_.nodes[node].list = static_cast<uint32_t>(out_.lists.size());
    out_.lists.push_back(static_cast<uint32_t>(entries.size()));
    for (const ListEntry& e : entries) {
      out_.lists.push_back(e.triangle);
      out_.lists.push_back(std::bit_cast<uint32_t>(e.reciprocal_depth));
    }
  }

  const Face& face_;
  const Detail& detail_;
  Subtree& out_;
};

}  // namespace

Subtree build_subtree(const Face& face, const Detail& detail, uint32_t i, uint32_t j,
                      std::vector<const Footprint*> met) {
  Subtree tree;
  tree.nodes.resize(1);
  const Rect rect = face.node_rect(kRootLevel, i, j);
  std::erase_if(met, [&](const Footprint* f) { return !meets(*f, rect); });
  Builder(face, detail, tree).build(0, kRootLevel, i, j, met);
  return tree;
}

}  // namespace gnomon::gpu::light_buffer
