#include "scenes/assets/unwrap.h"

#include <array>
#include <cstring>
#include <numeric>
#include <unordered_map>

#include "scenes/assets/random.h"

namespace gnomon::scenes::assets {
namespace {

constexpr uint32_t kNone = 0xffffffff;

struct PositionHash {
  size_t operator()(const glm::vec3& p) const {
    std::array<uint32_t, 3> bits{};
    std::memcpy(bits.data(), &p, sizeof p);
    return (bits[0] * size_t{73856093}) ^ (bits[1] * size_t{19349663}) ^ (bits[2] * size_t{83492791});
  }
};

// Connected pieces as a forest over the vertices; vertices at the same place are connected.
class Pieces {
 public:
  explicit Pieces(const Mesh& mesh) : parent_(mesh.positions.size()) {
    std::iota(parent_.begin(), parent_.end(), 0u);
    std::unordered_map<glm::vec3, uint32_t, PositionHash> first;
    for (uint32_t v = 0; v < mesh.positions.size(); ++v) {
      join(v, first.try_emplace(mesh.positions[v] + 0.0f, v).first->second);  // + 0: one zero instead of two
    }
    for (const glm::uvec3& t : mesh.triangles) join(t.x, t.y), join(t.y, t.z);
  }

  uint32_t of(uint32_t v) {
    while (parent_[v] != v) v = parent_[v] = parent_[parent_[v]];
    return v;
  }

 private:
  void join(uint32_t a, uint32_t b) { parent_[of(a)] = of(b); }

  std::vector<uint32_t> parent_;
};

struct Box {
  glm::vec3 low{1e30f}, high{-1e30f};
};

int largest_axis(const glm::vec3& v) {
  if (v.x >= v.y && v.x >= v.z) return 0;
  return v.y >= v.z ? 1 : 2;
}

// Where on the texture the point of a piece lies that is projected along `axis`.
glm::vec2 place(const glm::vec3& p, const Box& piece, int axis, float metres) {
  const int grain = largest_axis(piece.high - piece.low);
  const int u = axis == grain ? (axis + 1) % 3 : grain, v = 3 - axis - u;
  Random random(PositionHash()(piece.low) ^ static_cast<uint64_t>(axis));
  const glm::vec2 start(random.unit(), random.unit());
  return start + glm::vec2(p[u] - piece.low[u], p[v] - piece.low[v]) / metres;
}

}  // namespace

Mesh unwrapped(const Mesh& mesh, float metres) {
  Pieces pieces(mesh);
  std::unordered_map<uint32_t, Box> boxes;
  for (uint32_t v = 0; v < mesh.positions.size(); ++v) {
    Box& box = boxes[pieces.of(v)];
    box.low = glm::min(box.low, mesh.positions[v]), box.high = glm::max(box.high, mesh.positions[v]);
  }
  Mesh out;
  std::vector<uint32_t> made(3 * mesh.positions.size(), kNone);  // for each vertex and axis
  for (const glm::uvec3& t : mesh.triangles) {
    const glm::vec3 a = mesh.positions[t.x];
    const int axis = largest_axis(glm::abs(glm::cross(mesh.positions[t.y] - a, mesh.positions[t.z] - a)));
    glm::uvec3 corners;
    for (int k = 0; k < 3; ++k) {
      uint32_t& vertex = made[3 * size_t{t[k]} + static_cast<size_t>(axis)];
      if (vertex == kNone) {
        vertex = static_cast<uint32_t>(out.positions.size());
        out.positions.push_back(mesh.positions[t[k]]);
        out.normals.push_back(mesh.normals[t[k]]);
        out.uvs.push_back(place(mesh.positions[t[k]], boxes[pieces.of(t[k])], axis, metres));
      }
      corners[k] = vertex;
    }
    out.triangles.push_back(corners);
  }
  return out;
}

}  // namespace gnomon::scenes::assets
