#include "scenes/gltf/compressed.h"

#include <array>
#include <string>

namespace gnomon::scenes::gltf {
namespace {

using nlohmann::json;

constexpr const char* kDraco = "KHR_draco_mesh_compression";
constexpr std::array<const char*, 2> kMeshopt = {"EXT_meshopt_compression", "KHR_meshopt_compression"};

const json& member(const json& object, const char* key) {
  static const json kNothing;
  const auto found = object.is_object() ? object.find(key) : object.end();
  return found != object.end() ? *found : kNothing;
}

const json& element(const json& array, const json& index) {
  static const json kNothing;
  const bool exists = array.is_array() && index.is_number_unsigned() && index.get<uint64_t>() < array.size();
  return exists ? array[index.get<size_t>()] : kNothing;
}

const json& extension(const json& object, const char* name) { return member(member(object, "extensions"), name); }

Error only_in(const char* extension_name, const std::string& place) {
  return Error{place + " stands only in the extension " + extension_name +
               ", which is not supported: save the file without it, or with what it replaces"};
}

// Draco: the primitive's accessors have no buffer view, unless there is a fallback.
bool lacks_fallback(const json& root, const json& accessor_index) {
  const json& accessor = element(member(root, "accessors"), accessor_index);
  return accessor.is_object() && !accessor.contains("bufferView") && !accessor.contains("sparse");
}

Result<void> check_draco(const json& root) {
  const json& meshes = member(root, "meshes");
  for (size_t mesh = 0; meshes.is_array() && mesh < meshes.size(); ++mesh) {
    const json& primitives = member(meshes[mesh], "primitives");
    for (size_t i = 0; primitives.is_array() && i < primitives.size(); ++i) {
      const json& primitive = primitives[i];
      if (!extension(primitive, kDraco).is_object()) continue;
      if (lacks_fallback(root, member(member(primitive, "attributes"), "POSITION")) ||
          lacks_fallback(root, member(primitive, "indices"))) {
        return only_in(kDraco, "mesh " + std::to_string(mesh) + ", primitive " + std::to_string(i));
      }
    }
  }
  return {};
}

// Meshopt: the buffer view names a buffer that has no bytes and says so.
Result<void> check_meshopt(const json& root) {
  const json& views = member(root, "bufferViews");
  for (size_t i = 0; views.is_array() && i < views.size(); ++i) {
    const json& buffer = element(member(root, "buffers"), member(views[i], "buffer"));
    for (const char* name : kMeshopt) {
      const bool is_placeholder = member(extension(buffer, name), "fallback") == true && !buffer.contains("uri");
      if (is_placeholder && extension(views[i], name).is_object()) {
        return only_in(name, "buffer view " + std::to_string(i));
      }
    }
  }
  return {};
}

}  // namespace

Result<void> check_fallbacks(const json& root) {
  if (const auto ok = check_draco(root); !ok) return ok;
  return check_meshopt(root);
}

}  // namespace gnomon::scenes::gltf
