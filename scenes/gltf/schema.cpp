#include "scenes/gltf/schema.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>

namespace gnomon::scenes::gltf {
namespace {

using nlohmann::json;

bool is_size(const json& v) { return v.is_number_unsigned(); }
bool is_index(const json& v) { return v.is_number_unsigned() && v.get<uint64_t>() <= INT32_MAX; }
bool is_flag(const json& v) { return v.is_boolean(); }
bool is_text(const json& v) { return v.is_string(); }
bool is_object(const json& v) { return v.is_object(); }

bool is_number_list(const json& v) {
  return v.is_array() && std::all_of(v.begin(), v.end(), [](const json& n) { return n.is_number(); });
}
bool is_index_list(const json& v) { return v.is_array() && std::all_of(v.begin(), v.end(), is_index); }
bool is_object_list(const json& v) { return v.is_array() && std::all_of(v.begin(), v.end(), is_object); }
bool is_index_map(const json& v) { return v.is_object() && std::all_of(v.begin(), v.end(), is_index); }

struct Kind {
  bool (*holds)(const json&);
  const char* name;
};
constexpr Kind kSize{is_size, "a whole number that is not negative"};
constexpr Kind kIndex{is_index, "an index"};
constexpr Kind kFlag{is_flag, "true or false"};
constexpr Kind kText{is_text, "a text"};
constexpr Kind kObject{is_object, "an object"};
constexpr Kind kNumbers{is_number_list, "an array of numbers"};
constexpr Kind kIndices{is_index_list, "an array of indices"};
constexpr Kind kObjects{is_object_list, "an array of objects"};
constexpr Kind kIndexMap{is_index_map, "an object of indices"};

struct Rule {
  const char* array;  // of the file; entries are objects
  const char* key;
  Kind kind;
};
constexpr Rule kRules[] = {
    {"accessors", "bufferView", kIndex},  {"accessors", "byteOffset", kSize},
    {"accessors", "count", kSize},        {"accessors", "normalized", kFlag},
    {"accessors", "sparse", kObject},     {"bufferViews", "buffer", kIndex},
    {"bufferViews", "byteOffset", kSize}, {"bufferViews", "byteLength", kSize},
    {"bufferViews", "byteStride", kSize}, {"meshes", "primitives", kObjects},
    {"nodes", "camera", kIndex},          {"nodes", "children", kIndices},
    {"nodes", "matrix", kNumbers},        {"nodes", "mesh", kIndex},
    {"nodes", "rotation", kNumbers},      {"nodes", "scale", kNumbers},
    {"nodes", "translation", kNumbers},   {"scenes", "nodes", kIndices},
    {"materials", "alphaMode", kText},    {"materials", "pbrMetallicRoughness", kObject},
    {"textures", "source", kIndex},       {"textures", "sampler", kIndex},
    {"animations", "channels", kObjects}, {"animations", "samplers", kObjects},
};

struct PrimitiveRule {
  const char* key;
  Kind kind;
};
constexpr PrimitiveRule kPrimitiveRules[] = {
    {"attributes", kIndexMap}, {"indices", kIndex}, {"material", kIndex}, {"mode", kIndex}};

Result<void> check(const json& object, const std::string& place, const char* key, const Kind& kind) {
  const auto value = object.find(key);
  if (value == object.end() || kind.holds(*value)) return {};
  return Error{place + ": '" + key + "' is not " + kind.name};
}

Result<void> check_primitives(const json& mesh, const std::string& place) {
  const auto primitives = mesh.find("primitives");
  if (primitives == mesh.end()) return {};
  for (const json& primitive : *primitives) {
    for (const PrimitiveRule& rule : kPrimitiveRules) {
      if (const auto ok = check(primitive, place, rule.key, rule.kind); !ok) return ok;
    }
    if (!primitive.contains("attributes")) return Error{place + ": a primitive has no attributes"};
  }
  return {};
}

}  // namespace

Result<void> check_types(const json& root) {
  if (const auto ok = check(root, "the file", "scene", kIndex); !ok) return ok;
  for (const Rule& rule : kRules) {
    const auto array = root.find(rule.array);
    if (array == root.end()) continue;
    if (!kObjects.holds(*array)) return Error{std::string("'") + rule.array + "' is not " + kObjects.name};
    for (size_t i = 0; i < array->size(); ++i) {
      const json& entry = (*array)[i];
      if (!entry.contains(rule.key)) continue;
      const std::string place = std::string(rule.array) + " " + std::to_string(i);
      if (const auto ok = check(entry, place, rule.key, rule.kind); !ok) return ok;
    }
  }
  const auto meshes = root.find("meshes");
  for (size_t i = 0; meshes != root.end() && i < meshes->size(); ++i) {
    if (const auto ok = check_primitives((*meshes)[i], "meshes " + std::to_string(i)); !ok) return ok;
  }
  return {};
}

}  // namespace gnomon::scenes::gltf
