// Elements of glTF accessors: any component type, interleaved, sparse, normalised. Internal to scenes/gltf/.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "common/result.h"
#include "scenes/gltf/document.h"

namespace gnomon::scenes::gltf {

// An accessor whose elements are all known to lie within their buffers. Borrows from the document.
class Elements {
 public:
  // `type`: TINYGLTF_TYPE_SCALAR, _VEC2, ... Error: there is no such accessor, it has another type, or it reaches
  // beyond its buffer.
  static Result<Elements> of(const Document& document, int accessor, int type);

  size_t count() const { return count_; }
  bool is_unsigned() const;

  // The accessor has no bytes (no buffer view, or a buffer without a URI): every element is zero.
  bool all_zero() const { return base_ == nullptr && sparse_at_.empty(); }

  // The components of element i as numbers; normalised integers become -1 to 1 or 0 to 1, components that the type
  // lacks are 0. Precondition: i < count().
  glm::vec4 at(size_t i) const;
  // The first component of element i. Preconditions: i < count() and is_unsigned().
  uint32_t index_at(size_t i) const;

 private:
  const uint8_t* bytes_of(size_t i) const;
  Result<void> add_sparse(const Document& document, const tinygltf::Accessor& accessor);

  const uint8_t* base_ = nullptr;  // nullptr: all elements but the sparse ones are zero
  size_t stride_ = 0;
  size_t count_ = 0;
  size_t element_bytes_ = 0;
  int component_type_ = 0;
  int width_ = 0;
  bool normalized_ = false;
  std::vector<uint32_t> sparse_at_;  // indices of the sparse elements, increasing
  const uint8_t* sparse_values_ = nullptr;
};

// Reads the elements whose indices are in `wanted`, or all elements if it is empty.
std::vector<glm::vec3> read_vec3(const Elements& elements, std::span<const uint32_t> wanted = {});
std::vector<glm::vec2> read_vec2(const Elements& elements, std::span<const uint32_t> wanted = {});

}  // namespace gnomon::scenes::gltf
