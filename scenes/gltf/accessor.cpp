#include "scenes/gltf/accessor.h"

#include <algorithm>
#include <cstring>
#include <string>

namespace gnomon::scenes::gltf {
namespace {

size_t component_bytes(int type) {
  switch (type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE: return 1;
    case TINYGLTF_COMPONENT_TYPE_SHORT:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT: return 2;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
    case TINYGLTF_COMPONENT_TYPE_FLOAT: return 4;
    default: return 0;
  }
}

template <class T>
T load(const uint8_t* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  return value;
}

float component(const uint8_t* bytes, int type, bool normalized) {
  switch (type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE: {
      const float v = load<int8_t>(bytes);
      return normalized ? std::max(v / 127.0f, -1.0f) : v;
    }
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE: {
      const float v = load<uint8_t>(bytes);
      return normalized ? v / 255.0f : v;
    }
    case TINYGLTF_COMPONENT_TYPE_SHORT: {
      const float v = load<int16_t>(bytes);
      return normalized ? std::max(v / 32767.0f, -1.0f) : v;
    }
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT: {
      const float v = load<uint16_t>(bytes);
      return normalized ? v / 65535.0f : v;
    }
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT: return static_cast<float>(load<uint32_t>(bytes));
    default: return load<float>(bytes);
  }
}

// 0 for a component that is no unsigned integer.
size_t unsigned_bytes(int type) {
  switch (type) {
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT: return component_bytes(type);
    default: return 0;
  }
}

// Precondition: the type is an unsigned integer.
uint32_t unsigned_component(const uint8_t* bytes, int type) {
  switch (type) {
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE: return load<uint8_t>(bytes);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT: return load<uint16_t>(bytes);
    default: return load<uint32_t>(bytes);
  }
}

// The first byte of `count` elements in a buffer view. Error: they do not fit into it.
Result<const uint8_t*> range(const Document& document, int view, uint64_t offset, uint64_t count, uint64_t stride,
                             uint64_t element_bytes) {
  const auto bytes = document.view(view);
  if (!bytes) return bytes.error();
  const uint64_t size = bytes->size();
  const bool fits = count == 0 || (offset <= size && element_bytes <= size - offset &&
                                   (count - 1) <= (size - offset - element_bytes) / stride);
  if (!fits) return Error{"reaches beyond its buffer view"};
  return bytes->data() + offset;
}

Error named(int accessor, const std::string& what) {
  return Error{"accessor " + std::to_string(accessor) + " " + what};
}

template <class Vector>
std::vector<Vector> read(const Elements& elements, std::span<const uint32_t> wanted) {
  std::vector<Vector> out(wanted.empty() ? elements.count() : wanted.size());
  for (size_t i = 0; i < out.size(); ++i) out[i] = Vector(elements.at(wanted.empty() ? i : wanted[i]));
  return out;
}

}  // namespace

bool Elements::is_unsigned() const {
  return component_type_ == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ||
         component_type_ == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ||
         component_type_ == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
}

Result<Elements> Elements::of(const Document& document, int index, int type) {
  const auto found = entry(document.model.accessors, index, "accessor");
  if (!found) return found.error();
  const tinygltf::Accessor& accessor = **found;
  Elements e;
  e.count_ = accessor.count;
  e.component_type_ = accessor.componentType;
  e.normalized_ = accessor.normalized;
  e.width_ = tinygltf::GetNumComponentsInType(static_cast<uint32_t>(type));
  e.element_bytes_ = component_bytes(accessor.componentType) * static_cast<size_t>(e.width_);
  if (accessor.type != type) return named(index, "has another type than its use needs");
  if (e.element_bytes_ == 0) return named(index, "has a component type that glTF does not know");
  if (document.lacks_bytes(accessor.bufferView)) {
    const auto granted = document.budget.spend(e.count_, e.element_bytes_);  // its count costs the file nothing
    if (!granted) return named(index, "has no bytes of its own, and " + granted.error().message);
  } else {
    const auto view = entry(document.model.bufferViews, accessor.bufferView, "buffer view");
    if (!view) return named(index, view.error().message);
    e.stride_ = (*view)->byteStride != 0 ? (*view)->byteStride : e.element_bytes_;
    const auto base =
        range(document, accessor.bufferView, accessor.byteOffset, e.count_, e.stride_, e.element_bytes_);
    if (!base) return named(index, base.error().message);
    e.base_ = *base;
  }
  if (accessor.sparse.isSparse) {
    if (const auto ok = e.add_sparse(document, accessor); !ok) return named(index, ok.error().message);
  }
  return e;
}

Result<void> Elements::add_sparse(const Document& document, const tinygltf::Accessor& accessor) {
  const auto& sparse = accessor.sparse;
  const size_t bytes = unsigned_bytes(sparse.indices.componentType);
  if (sparse.count < 0 || sparse.indices.byteOffset < 0 || sparse.values.byteOffset < 0 || bytes == 0) {
    return Error{"has a sparse part that is not valid"};
  }
  const auto count = static_cast<size_t>(sparse.count);
  const auto indices = range(document, sparse.indices.bufferView, static_cast<uint64_t>(sparse.indices.byteOffset),
                             count, bytes, bytes);
  if (!indices) return Error{"sparse indices: " + indices.error().message};
  const auto values = range(document, sparse.values.bufferView, static_cast<uint64_t>(sparse.values.byteOffset),
                            count, element_bytes_, element_bytes_);
  if (!values) return Error{"sparse values: " + values.error().message};
  const auto granted = document.budget.spend(count, sizeof sparse_at_[0]);
  if (!granted) return Error{"is sparse, and " + granted.error().message};
  sparse_values_ = *values;
  sparse_at_.resize(count);
  for (size_t i = 0; i < count; ++i) {
    sparse_at_[i] = unsigned_component(*indices + i * bytes, sparse.indices.componentType);
    if (sparse_at_[i] >= count_ || (i > 0 && sparse_at_[i] <= sparse_at_[i - 1])) {
      return Error{"has sparse indices that do not increase or are out of range"};
    }
  }
  return {};
}

const uint8_t* Elements::bytes_of(size_t i) const {
  if (!sparse_at_.empty()) {
    const auto it = std::lower_bound(sparse_at_.begin(), sparse_at_.end(), i);
    if (it != sparse_at_.end() && *it == i) {
      return sparse_values_ + static_cast<size_t>(it - sparse_at_.begin()) * element_bytes_;
    }
  }
  return base_ == nullptr ? nullptr : base_ + i * stride_;
}

glm::vec4 Elements::at(size_t i) const {
  glm::vec4 out(0.0f);
  const uint8_t* bytes = bytes_of(i);
  if (bytes == nullptr) return out;
  const size_t step = element_bytes_ / static_cast<size_t>(width_);
  for (int c = 0; c < std::min(width_, 4); ++c) {
    out[c] = component(bytes + static_cast<size_t>(c) * step, component_type_, normalized_);
  }
  return out;
}

uint32_t Elements::index_at(size_t i) const {
  const uint8_t* bytes = bytes_of(i);
  return bytes == nullptr ? 0 : unsigned_component(bytes, component_type_);
}

std::vector<glm::vec3> read_vec3(const Elements& elements, std::span<const uint32_t> wanted) {
  return read<glm::vec3>(elements, wanted);
}

std::vector<glm::vec2> read_vec2(const Elements& elements, std::span<const uint32_t> wanted) {
  return read<glm::vec2>(elements, wanted);
}

}  // namespace gnomon::scenes::gltf
