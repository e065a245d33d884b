#include "gpu/builds/bvh.h"

#include <algorithm>
#include <array>
#include <future>
#include <limits>
#include <span>

namespace gnomon::gpu {
namespace {

constexpr uint32_t kBins = 16;
constexpr uint32_t kMaxLeaf = 4;          // triangles, unless all centroids coincide
constexpr uint32_t kHardMaxLeaf = 15;     // the most that BvhNode::leaf can hold
constexpr uint32_t kParallelFrom = 8192;  // triangles of a subtree that is worth a thread of its own
constexpr float kNodeCost = 1.0f;         // cost of visiting a node, in triangle tests

struct Box {
  glm::vec3 lo{std::numeric_limits<float>::infinity()};
  glm::vec3 hi{-std::numeric_limits<float>::infinity()};

  void grow(const Box& b) {
    lo = glm::min(lo, b.lo);
    hi = glm::max(hi, b.hi);
  }
  void grow(const glm::vec3& p) {
    lo = glm::min(lo, p);
    hi = glm::max(hi, p);
  }
  float half_area() const {
    const glm::vec3 d = glm::max(hi - lo, glm::vec3(0.0f));
    return d.x * d.y + d.y * d.z + d.z * d.x;
  }
  glm::vec3 centre() const { return 0.5f * (lo + hi); }
};

// A triangle while the builder sorts it. Items are moved rather than referred to, because neighbours that are adjacent
// in memory make the build faster.
struct Item {
  Box box;
  uint32_t triangle = 0;
};

// Assigns items to bins of equal width along each axis, by the centres of their boxes.
struct Bins {
  glm::vec3 low, per_unit;

  explicit Bins(const Box& centres)
      : low(centres.lo), per_unit(static_cast<float>(kBins) / (centres.hi - centres.lo)) {}
  // Precondition: the centres differ along the axis.
  uint32_t of(const Item& item, int axis) const {
    const float at = (item.box.centre()[axis] - low[axis]) * per_unit[axis];
    return std::min(static_cast<uint32_t>(at), kBins - 1);
  }
};

struct Split {
  int axis = -1;
  uint32_t bin = 0;  // the triangles of lower bins form the first half
  float cost = std::numeric_limits<float>::infinity();
};

// A subtree with `skip` and leaf numbers relative to its own first node and triangle.
using Subtree = std::vector<BvhNode>;

class Builder {
 public:
  Builder(const scenes::WorldMesh& mesh, unsigned threads) : threads_(threads) {
    items_.reserve(mesh.triangles.size());
    for (const glm::uvec3& t : mesh.triangles) {
      Box box;
      for (int i = 0; i < 3; ++i) box.grow(mesh.positions[t[i]]);
      items_.push_back({box, static_cast<uint32_t>(items_.size())});
    }
  }

  Subtree build() {
    if (items_.empty()) return {};
    unsigned depth = 0;
    while ((1u << depth) < threads_ * 4) ++depth;
    return build(items_, 0, threads_ > 1 ? depth : 0);
  }
  const std::vector<Item>& items() const { return items_; }  // in the order of the leaves, once built

 private:
  // `part`: the slice of items_ that begins at `first`.
  Subtree build(std::span<Item> part, uint32_t first, unsigned parallel_depth) {
    Box bounds, centres;
    for (const Item& item : part) {
      bounds.grow(item.box);
      centres.grow(item.box.centre());
    }
    const uint32_t count = static_cast<uint32_t>(part.size());
    const Split split = best_split(part, centres);
    const float leaf_cost = static_cast<float>(count) * bounds.half_area();
    if (count <= kMaxLeaf && leaf_cost <= split.cost + kNodeCost * bounds.half_area())
      return {{bounds.lo, 1, bounds.hi, first << 4 | count}};

    const size_t middle = divide(part, split, centres);
    if (middle == 0) return {{bounds.lo, 1, bounds.hi, first << 4 | count}};
    const auto left = part.first(middle), right = part.subspan(middle);
    const uint32_t right_first = first + static_cast<uint32_t>(middle);
    Subtree a, b;
    if (parallel_depth > 0 && count >= kParallelFrom) {
      auto other = std::async(std::launch::async, [&] { return build(right, right_first, parallel_depth - 1); });
      a = build(left, first, parallel_depth - 1);
      b = other.get();
    } else {
      a = build(left, first, 0);
      b = build(right, right_first, 0);
    }
    return join(bounds, a, b);
  }

  static Subtree join(const Box& bounds, const Subtree& a, const Subtree& b) {
    Subtree out;
    out.reserve(1 + a.size() + b.size());
    out.push_back({bounds.lo, static_cast<uint32_t>(1 + a.size() + b.size()), bounds.hi, 0});
    append(out, a);
    append(out, b);
    return out;
  }
  static void append(Subtree& out, const Subtree& part) {
    const uint32_t base = static_cast<uint32_t>(out.size());
    for (BvhNode node : part) {
      node.skip += base;
      out.push_back(node);
    }
  }

  static Split best_split(std::span<const Item> part, const Box& centres) {
    Split best;
    const Bins bins(centres);
    for (int axis = 0; axis < 3; ++axis) {
      if (centres.hi[axis] <= centres.lo[axis]) continue;
      std::array<Box, kBins> boxes;
      std::array<uint32_t, kBins> counts{};
      for (const Item& item : part) {
        const uint32_t bin = bins.of(item, axis);
        boxes[bin].grow(item.box);
        ++counts[bin];
      }
      std::array<float, kBins> below{};  // cost of the triangles in lower bins
      Box box;
      uint32_t count = 0;
      for (uint32_t bin = 0; bin + 1 < kBins; ++bin) {
        box.grow(boxes[bin]);
        count += counts[bin];
        below[bin + 1] = count ? static_cast<float>(count) * box.half_area() : 0.0f;
      }
      box = {};
      count = 0;
      for (uint32_t bin = kBins - 1; bin > 0; --bin) {
        box.grow(boxes[bin]);
        count += counts[bin];
        const float cost = below[bin] + (count ? static_cast<float>(count) * box.half_area() : 0.0f);
        if (count > 0 && count < part.size() && cost < best.cost) best = {axis, bin, cost};
      }
    }
    return best;
  }

  // Returns the index at which the second half begins; 0 if the part cannot be divided and fits into a leaf.
  static size_t divide(std::span<Item> part, const Split& split, const Box& centres) {
    if (split.axis < 0) return part.size() <= kHardMaxLeaf ? 0 : part.size() / 2;
    const Bins bins(centres);
    const auto middle = std::partition(part.begin(), part.end(),
                                       [&](const Item& item) { return bins.of(item, split.axis) < split.bin; });
    return static_cast<size_t>(middle - part.begin());
  }

  unsigned threads_;
  std::vector<Item> items_;
};

}  // namespace

Bvh build_bvh(const scenes::WorldMesh& mesh, unsigned threads) {
  Builder builder(mesh, threads);
  Bvh bvh;
  bvh.nodes = builder.build();
  bvh.triangles.reserve(builder.items().size());
  for (const Item& item : builder.items()) {
    const uint32_t t = item.triangle;
    const glm::uvec3 corners = mesh.triangles[t];
    bvh.triangles.push_back({mesh.positions[corners.x], t, mesh.positions[corners.y],
                             t >= mesh.opaque_count ? 1u : 0u, mesh.positions[corners.z], 0});
  }
  return bvh;
}

}  // namespace gnomon::gpu
