#include "scenes/gltf/geometry.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <string>

#include "scenes/gltf/accessor.h"

namespace gnomon::scenes::gltf {
namespace {

using Corners = std::vector<uint32_t>;

bool finite(const glm::vec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }
bool finite(const glm::vec2& v) { return std::isfinite(v.x) && std::isfinite(v.y); }

uint64_t triangles_of(int mode, uint64_t corners) {
  if (mode == TINYGLTF_MODE_TRIANGLES) return corners / 3;
  return corners < 3 ? 0 : corners - 2;
}

// Corners of triangle `i` of a list, strip or fan (glTF 2.0, 3.7.2.1). Every second triangle of a strip is reversed.
glm::uvec3 triangle(int mode, uint32_t i) {
  if (mode == TINYGLTF_MODE_TRIANGLES) return {3 * i, 3 * i + 1, 3 * i + 2};
  if (mode == TINYGLTF_MODE_TRIANGLE_FAN) return {i + 1, i + 2, 0};
  return i % 2 == 0 ? glm::uvec3(i, i + 1, i + 2) : glm::uvec3(i, i + 2, i + 1);
}

constexpr uint64_t kCornerBytes =
    2 * sizeof(uint32_t) + sizeof(glm::uvec3);  // listed, sorted, and of a strip's triangle
constexpr uint64_t kVertexBytes = 2 * sizeof(glm::vec3) + sizeof(glm::vec2);

// The vertex of each corner: the indices, or 0, 1, 2, ... if there are none. Error: an index beyond the vertices, or
// more than `max_corners`.
Result<Corners> read_corners(const Document& document, int indices, size_t vertices, uint64_t max_corners) {
  const Error too_many{"has more triangles than the scene may have"};
  if (indices == -1) {
    if (vertices > max_corners) return too_many;
    if (const auto ok = document.budget.spend(vertices, kCornerBytes); !ok) return ok.error();
    Corners corners(vertices);
    std::iota(corners.begin(), corners.end(), 0u);
    return corners;
  }
  const Result<Elements> elements = Elements::of(document, indices, TINYGLTF_TYPE_SCALAR);
  if (!elements) return Error{"indices: " + elements.error().message};
  if (!elements->is_unsigned()) return Error{"has indices that are not unsigned integers"};
  if (elements->count() > max_corners) return too_many;
  if (const auto ok = document.budget.spend(elements->count(), kCornerBytes); !ok) return ok.error();
  Corners corners(elements->count());
  for (size_t i = 0; i < corners.size(); ++i) {
    corners[i] = elements->index_at(i);
    if (corners[i] >= vertices) {
      return Error{"has the index " + std::to_string(corners[i]) + " with only " + std::to_string(vertices) +
                   " vertices"};
    }
  }
  return corners;
}

// Returns the vertices that the corners use, and renumbers the corners accordingly. Many primitives may share one large
// accessor; each keeps only the vertices that it uses.
Corners take_used(Corners& corners) {
  Corners used = corners;
  std::sort(used.begin(), used.end());
  used.erase(std::unique(used.begin(), used.end()), used.end());
  for (uint32_t& corner : corners) {
    corner = static_cast<uint32_t>(std::lower_bound(used.begin(), used.end(), corner) - used.begin());
  }
  return used;
}

int attribute(const tinygltf::Primitive& source, const std::string& name) {
  const auto it = source.attributes.find(name);
  return it == source.attributes.end() ? -1 : it->second;
}

// Reads one primitive's attributes for the vertices in `used` (all, if empty).
class Attributes {
 public:
  Attributes(const Document& document, const tinygltf::Primitive& source, size_t vertices, Corners used)
      : document_(document), source_(source), vertices_(vertices), used_(std::move(used)) {}

  Result<std::vector<glm::vec3>> positions(const Elements& elements) const {
    std::vector<glm::vec3> out = read_vec3(elements, used_);
    for (const glm::vec3& p : out) {
      if (!finite(p)) return Error{"has a position that is not a finite number"};
    }
    return out;
  }

  Result<std::vector<glm::vec3>> normals() const {
    const auto elements = of("NORMAL", TINYGLTF_TYPE_VEC3);
    if (!elements) return elements.error();
    if (!*elements) return std::vector<glm::vec3>{};
    std::vector<glm::vec3> out = read_vec3(**elements, used_);
    for (glm::vec3& n : out) {
      const float length = glm::length(n);
      if (!std::isnormal(length)) return std::vector<glm::vec3>{};
      n /= length;
    }
    return out;
  }

  Result<std::vector<glm::vec2>> uvs(const TextureCoordinates& coordinates) const {
    const auto elements = of("TEXCOORD_" + std::to_string(coordinates.set), TINYGLTF_TYPE_VEC2);
    if (!elements) return elements.error();
    if (!*elements) return std::vector<glm::vec2>{};
    std::vector<glm::vec2> out = read_vec2(**elements, used_);
    for (glm::vec2& uv : out) {
      uv = glm::vec2(coordinates.transform * glm::vec3(uv, 1.0f));
      if (!finite(uv)) return Error{"has a texture coordinate that is not a finite number"};
    }
    return out;
  }

 private:
  // The elements of that attribute; nullopt if the primitive does not have it.
  Result<std::optional<Elements>> of(const std::string& name, int type) const {
    const int accessor = attribute(source_, name);
    if (accessor == -1) return std::optional<Elements>();
    Result<Elements> elements = Elements::of(document_, accessor, type);
    if (!elements) return Error{name + ": " + elements.error().message};
    if (elements->count() < vertices_) return Error{name + " has fewer elements than POSITION"};
    return std::optional<Elements>(std::move(*elements));
  }

  const Document& document_;
  const tinygltf::Primitive& source_;
  size_t vertices_;
  Corners used_;
};

// nullopt if the primitive has no triangles.
using MaybePrimitive = std::optional<Primitive>;

Result<uint32_t> material_of(const tinygltf::Primitive& source, const Materials& materials) {
  if (source.material == -1) return materials.default_material;
  if (source.material < 0 || static_cast<uint32_t>(source.material) >= materials.default_material) {
    return Error{"uses material " + std::to_string(source.material) + ", which does not exist"};
  }
  return static_cast<uint32_t>(source.material);
}

std::vector<glm::uvec3> assemble(int mode, const Corners& corners) {
  std::vector<glm::uvec3> triangles(triangles_of(mode, corners.size()));
  for (uint32_t i = 0; i < triangles.size(); ++i) {
    const glm::uvec3 t = triangle(mode, i);
    triangles[i] = {corners[t.x], corners[t.y], corners[t.z]};
  }
  return triangles;
}

Result<MaybePrimitive> read_primitive(const Document& document, const tinygltf::Primitive& source,
                                      const Materials& materials, uint64_t max_triangles) {
  const bool flat_kind = source.mode >= TINYGLTF_MODE_POINTS && source.mode < TINYGLTF_MODE_TRIANGLES;
  const int position = attribute(source, "POSITION");
  if (flat_kind || position == -1) return MaybePrimitive();
  if (source.mode < 0 || source.mode > TINYGLTF_MODE_TRIANGLE_FAN) {
    return Error{"has the mode " + std::to_string(source.mode) + ", which glTF does not know"};
  }
  const Result<Elements> vertices = Elements::of(document, position, TINYGLTF_TYPE_VEC3);
  if (!vertices) return Error{"POSITION: " + vertices.error().message};
  if (vertices->all_zero()) return MaybePrimitive();
  Result<Corners> corners = read_corners(document, source.indices, vertices->count(), 3 * max_triangles + 2);
  if (!corners) return corners.error();
  if (triangles_of(source.mode, corners->size()) > max_triangles) {
    return Error{"has more triangles than the scene may have"};
  }
  if (triangles_of(source.mode, corners->size()) == 0) return MaybePrimitive();

  const Result<uint32_t> material = material_of(source, materials);
  if (!material) return material.error();
  Corners used = vertices->count() > corners->size() ? take_used(*corners) : Corners();
  const size_t kept = used.empty() ? vertices->count() : used.size();
  if (const auto ok = document.budget.spend(kept, kVertexBytes); !ok) return ok.error();
  const Attributes attributes(document, source, vertices->count(), std::move(used));
  auto positions = attributes.positions(*vertices);
  if (!positions) return positions.error();
  auto normals = attributes.normals();
  if (!normals) return normals.error();
  Primitive primitive{*material, std::move(*positions), std::move(*normals), {}, assemble(source.mode, *corners)};
  if (materials.materials[*material].base_color_texture != kNone) {
    auto uvs = attributes.uvs(materials.coordinates[*material]);
    if (!uvs) return uvs.error();
    primitive.uvs = std::move(*uvs);
  }
  return MaybePrimitive(std::move(primitive));
}

}  // namespace

Result<Mesh> read_mesh(const Document& document, int index, const Materials& materials, uint64_t max_triangles) {
  const auto source = entry(document.model.meshes, index, "mesh");
  if (!source) return source.error();
  Mesh mesh;
  mesh.name = (*source)->name;
  uint64_t triangles = 0;
  for (size_t i = 0; i < (*source)->primitives.size(); ++i) {
    auto primitive = read_primitive(document, (*source)->primitives[i], materials, max_triangles - triangles);
    if (!primitive) {
      return Error{"mesh " + std::to_string(index) + " '" + mesh.name + "', primitive " + std::to_string(i) + ": " +
                   primitive.error().message};
    }
    if (!*primitive) continue;
    triangles += (*primitive)->triangles.size();
    mesh.primitives.push_back(std::move(**primitive));
  }
  return mesh;
}

uint64_t triangle_count(const Mesh& mesh) {
  uint64_t count = 0;
  for (const Primitive& p : mesh.primitives) count += p.triangles.size();
  return count;
}

}  // namespace gnomon::scenes::gltf
