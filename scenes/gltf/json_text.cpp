#include "scenes/gltf/json_text.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "scenes/gltf/compressed.h"
#include "scenes/gltf/schema.h"
#include "scenes/gltf/surroundings.h"

namespace gnomon::scenes::gltf {
namespace {

using nlohmann::json;

constexpr size_t kMaxTextBytes = size_t{1} << 30;
constexpr size_t kMaxDepth = 64;  // glTF itself needs 8
// tinygltf allocates up to 2 KB for an empty entry of an array, which is three bytes of JSON.
constexpr size_t kMaxNodes = size_t{1} << 20;
constexpr size_t kMaxEntries = size_t{1} << 18;

// The extensions that a file may require. Those that only change the appearance of a surface are ignored.
constexpr std::array<std::string_view, 17> kSupported = {"KHR_lights_punctual",
                                                         "KHR_mesh_quantization",
                                                         "KHR_texture_transform",
                                                         "KHR_materials_anisotropy",
                                                         "KHR_materials_clearcoat",
                                                         "KHR_materials_dispersion",
                                                         "KHR_materials_emissive_strength",
                                                         "KHR_materials_ior",
                                                         "KHR_materials_iridescence",
                                                         "KHR_materials_sheen",
                                                         "KHR_materials_specular",
                                                         "KHR_materials_transmission",
                                                         "KHR_materials_unlit",
                                                         "KHR_materials_variants",
                                                         "KHR_materials_volume",
                                                         "KHR_xmp_json_ld",
                                                         "KHR_xmp"};
// The extensions that the loader reads; all others are removed.
constexpr std::array<std::string_view, 3> kRead = {"KHR_lights_punctual", "KHR_texture_transform",
                                                   "KHR_materials_emissive_strength"};

template <class List>
bool contains(const List& list, std::string_view name) {
  return std::find(list.begin(), list.end(), name) != list.end();
}

// Checked on the text, because the parser does not recurse, but copying and printing a JSON value do.
bool nested_too_deeply(std::string_view text) {
  size_t depth = 0;
  bool in_string = false;
  for (size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_string) {
      if (c == '\\') ++i;
      if (c == '"') in_string = false;
    } else if (c == '"') {
      in_string = true;
    } else if (c == '[' || c == '{') {
      if (++depth > kMaxDepth) return true;
    } else if ((c == ']' || c == '}') && depth > 0) {
      --depth;
    }
  }
  return false;
}

void keep_what_is_read(json& object) {
  object.erase("extras");
  const auto extensions = object.find("extensions");
  if (extensions == object.end() || !extensions->is_object()) return;
  for (auto it = extensions->begin(); it != extensions->end();) {
    it = contains(kRead, it.key()) ? std::next(it) : extensions->erase(it);
  }
}

// Turns 36.0 into 36: JSON does not distinguish the two, but tinygltf does.
void make_whole(json& number) {
  const double v = number.get<double>();
  if (v != std::floor(v) || std::abs(v) > INT32_MAX) return;
  number = v >= 0.0 ? json(static_cast<uint64_t>(v)) : json(static_cast<int64_t>(v));
}

void normalise(json& value) {
  if (value.is_object()) keep_what_is_read(value);
  if (value.is_number_float()) make_whole(value);
  if (value.is_structured()) {
    for (json& child : value) normalise(child);
  }
}

// Replaces accessors of unknown types by empty ones, so that a type of a later version is an error only where it is
// used. The other accessors keep their indices.
void blank_unknown_accessors(json& root) {
  constexpr std::array<std::string_view, 7> kTypes = {"SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4"};
  const auto accessors = root.find("accessors");
  if (accessors == root.end() || !accessors->is_array()) return;
  for (json& accessor : *accessors) {
    const bool has_type = accessor.is_object() && accessor.contains("type") && accessor["type"].is_string();
    if (has_type && !contains(kTypes, accessor["type"].get_ref<const std::string&>())) {
      accessor = {{"componentType", 5126}, {"type", "SCALAR"}, {"count", 0}};
    }
  }
}

Result<void> check_version(const json& root) {
  const auto asset = root.find("asset");
  if (asset == root.end() || !asset->is_object()) return Error{"it has no 'asset' object: not a glTF 2.0 file"};
  const auto version = asset->find("version");
  if (version == asset->end() || !version->is_string()) return Error{"'asset.version' is missing"};
  const std::string text = version->get<std::string>();
  if (text.rfind("2.", 0) != 0) return Error{"it is glTF '" + text + "'; only glTF 2.0 is read"};
  return {};
}

Result<void> check_extensions(const json& root) {
  const auto required = root.find("extensionsRequired");
  if (required == root.end()) return {};
  if (!required->is_array()) return Error{"'extensionsRequired' is not an array"};
  for (const json& name : *required) {
    if (!name.is_string()) return Error{"'extensionsRequired' holds something other than names"};
    const std::string text = name.get<std::string>();
    if (!contains(kSupported, text)) return Error{"it requires the extension " + text + ", which is not supported"};
  }
  return {};
}

Result<void> check_counts(const json& root) {
  constexpr std::array<const char*, 13> kArrays = {"accessors", "animations", "buffers", "bufferViews", "cameras",
                                                   "images",    "materials",  "meshes",  "nodes",       "samplers",
                                                   "scenes",    "skins",      "textures"};
  for (const char* name : kArrays) {
    const auto array = root.find(name);
    if (array == root.end()) continue;
    if (!array->is_array()) return Error{std::string("'") + name + "' is not an array"};
    const size_t limit = std::string_view(name) == "nodes" ? kMaxNodes : kMaxEntries;
    if (array->size() > limit) return Error{"it has " + std::to_string(array->size()) + " " + name + ": too many"};
  }
  return {};
}

// Replaces the characters that are not printable: nlohmann's messages quote the bytes that it could not parse.
std::string printable(std::string text) {
  const auto odd = [](char c) { return c < ' ' || c > '~'; };
  std::replace_if(text.begin(), text.end(), odd, '?');
  return text;
}

Result<json> parsed(std::string_view text) {
  try {
    return json::parse(text.begin(), text.end());
  } catch (const json::exception& e) {
    return Error{"its JSON cannot be read: " + printable(e.what())};
  }
}

}  // namespace

Result<json> parse_gltf_json(std::string_view text, Extras& extras) {
  if (text.size() > kMaxTextBytes) return Error{"its JSON has " + std::to_string(text.size()) + " bytes: too many"};
  if (nested_too_deeply(text)) return Error{"its JSON is nested more than " + std::to_string(kMaxDepth) + " deep"};
  Result<json> root = parsed(text);
  if (!root) return root;
  if (!root->is_object()) return Error{"its JSON is not an object"};
  if (const auto ok = check_version(*root); !ok) return ok.error();
  if (const auto ok = check_extensions(*root); !ok) return ok.error();
  if (const auto ok = check_counts(*root); !ok) return ok.error();
  if (const auto ok = check_fallbacks(*root); !ok) return ok.error();
  extras = {read_surroundings(*root), read_light_areas(*root)};
  normalise(*root);
  if (const auto ok = check_types(*root); !ok) return ok.error();
  blank_unknown_accessors(*root);
  return root;
}

}  // namespace gnomon::scenes::gltf
