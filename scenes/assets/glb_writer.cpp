#include "scenes/assets/glb_writer.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <span>

#include "scenes/assets/unwrap.h"

namespace gnomon::scenes::assets {
namespace {

using Json = nlohmann::ordered_json;

// Constants of the glTF 2.0 specification.
constexpr int kUnsignedShort = 5123, kUnsignedInt = 5125, kFloat = 5126;
constexpr int kVertexData = 34962, kIndexData = 34963, kClampToEdge = 33071, kRepeat = 10497, kLinear = 9729;
constexpr int kLinearMipmapLinear = 9987;
constexpr uint32_t kMagic = 0x46546c67, kVersion = 2, kJsonChunk = 0x4e4f534a, kBinaryChunk = 0x004e4942;

Json vector_json(const float* values, int count) {
  Json array = Json::array();
  for (int i = 0; i < count; ++i) array.push_back(values[i]);
  return array;
}
Json to_json(glm::vec3 v) { return vector_json(&v.x, 3); }
Json to_json(glm::quat q) { return Json::array({q.x, q.y, q.z, q.w}); }

class Writer {
 public:
  explicit Writer(const Stage& stage) : stage_(stage) {}

  std::vector<uint8_t> write() {
    document_["asset"] = {{"version", "2.0"}, {"generator", "gnomon-make-scenes"}};
    document_["extensionsUsed"] = {"KHR_lights_punctual"};
    document_["scene"] = 0;
    add_materials();
    for (const Model& model : stage_.models) add_model(model);
    for (const Node& node : stage_.nodes) add_placement(node);
    for (const Light& light : stage_.lights) add_light(light);
    add_camera();
    Json all = Json::array();
    for (size_t i = 0; i < document_["nodes"].size(); ++i) all.push_back(i);
    const Surroundings& around = stage_.surroundings;
    const Json ambient = {{"above", to_json(around.ambient_above)}, {"below", to_json(around.ambient_below)}};
    const Json sky = {{"zenith", to_json(around.zenith)},
                      {"horizon", to_json(around.horizon)},
                      {"ground", to_json(around.ground)},
                      {"clouds", around.clouds}};
    const Json gnomon = {{"ambient", ambient}, {"sky", sky}};
    document_["scenes"] = Json::array({{{"name", stage_.name}, {"nodes", all}, {"extras", {{"gnomon", gnomon}}}}});
    align();
    document_["buffers"] = Json::array({{{"byteLength", binary_.size()}}});
    return file();
  }

 private:
  void align() { binary_.resize((binary_.size() + 3) / 4 * 4); }

  template <class T>
  size_t add_view(std::span<const T> values, int target) {
    align();
    Json view = {{"buffer", 0}, {"byteOffset", binary_.size()}, {"byteLength", values.size_bytes()}};
    if (target) view["target"] = target;
    const auto* bytes = reinterpret_cast<const uint8_t*>(values.data());
    binary_.insert(binary_.end(), bytes, bytes + values.size_bytes());
    document_["bufferViews"].push_back(view);
    return document_["bufferViews"].size() - 1;
  }

  size_t add_accessor(size_t view, int component, size_t count, const char* type, const Json& bounds = {}) {
    Json accessor = {{"bufferView", view}, {"componentType", component}, {"count", count}, {"type", type}};
    if (!bounds.is_null()) accessor.update(bounds);
    document_["accessors"].push_back(accessor);
    return document_["accessors"].size() - 1;
  }

  template <class V>
  size_t add_vectors(const std::vector<V>& values, const char* type, int target = kVertexData,
                     const Json& bounds = {}) {
    return add_accessor(add_view(std::span<const V>(values), target), kFloat, values.size(), type, bounds);
  }

  size_t add_indices(const Mesh& mesh) {
    const size_t count = mesh.triangles.size() * 3;
    if (mesh.positions.size() > std::numeric_limits<uint16_t>::max()) {
      return add_accessor(add_view(std::span<const glm::uvec3>(mesh.triangles), kIndexData), kUnsignedInt, count,
                          "SCALAR");
    }
    std::vector<uint16_t> narrow;
    for (const glm::uvec3& t : mesh.triangles) {
      for (int k = 0; k < 3; ++k) narrow.push_back(static_cast<uint16_t>(t[k]));
    }
    return add_accessor(add_view(std::span<const uint16_t>(narrow), kIndexData), kUnsignedShort, count, "SCALAR");
  }

  void add_materials() {
    for (const std::vector<uint8_t>& png : stage_.images) {
      // Called first, because adding a member to the document invalidates references to the others.
      const auto view = add_view(std::span<const uint8_t>(png), 0);
      document_["images"].push_back({{"bufferView", view}, {"mimeType", "image/png"}});
      const size_t image = document_["images"].size() - 1;
      const bool cuts = std::any_of(stage_.materials.begin(), stage_.materials.end(),
                                    [&](const Material& m) { return m.cutout == image; });
      document_["textures"].push_back({{"sampler", cuts ? 0 : 1}, {"source", image}});
    }
    for (const int wrap : {kClampToEdge, kRepeat}) {
      document_["samplers"].push_back(
          {{"magFilter", kLinear}, {"minFilter", kLinearMipmapLinear}, {"wrapS", wrap}, {"wrapT", wrap}});
    }
    for (const Material& m : stage_.materials) {
      Json surface = {{"baseColorFactor", {m.base_color.r, m.base_color.g, m.base_color.b, 1.0f}},
                      {"metallicFactor", m.metallic},
                      {"roughnessFactor", m.roughness}};
      Json material = {{"name", m.name}};
      if (m.cutout != kNoImage) {
        surface["baseColorTexture"] = {{"index", m.cutout}};
        material["alphaMode"] = "MASK", material["alphaCutoff"] = 0.5f, material["doubleSided"] = true;
      }
      if (m.texture != kNoImage) surface["baseColorTexture"] = {{"index", m.texture}};
      material["pbrMetallicRoughness"] = surface;
      if (m.emissive != glm::vec3(0.0f)) material["emissiveFactor"] = to_json(m.emissive);
      document_["materials"].push_back(material);
    }
  }

  void add_model(const Model& model) {
    Json primitives = Json::array();
    for (const Part& part : model.parts) {
      const Material& material = stage_.materials[part.material];
      const Mesh mesh = material.texture == kNoImage ? part.mesh : unwrapped(part.mesh, material.texture_metres);
      glm::vec3 low = mesh.positions.front(), high = low;
      for (const glm::vec3& p : mesh.positions) low = glm::min(low, p), high = glm::max(high, p);
      const Json bounds = {{"min", to_json(low)}, {"max", to_json(high)}};
      Json attributes = {{"POSITION", add_vectors(mesh.positions, "VEC3", kVertexData, bounds)},
                         {"NORMAL", add_vectors(mesh.normals, "VEC3")}};
      const bool textured = material.cutout != kNoImage || material.texture != kNoImage;
      if (textured) attributes["TEXCOORD_0"] = add_vectors(mesh.uvs, "VEC2");
      primitives.push_back(
          {{"attributes", attributes}, {"indices", add_indices(mesh)}, {"material", part.material}});
    }
    document_["meshes"].push_back({{"name", model.name}, {"primitives", primitives}});
  }

  void add_placement(const Node& node) {
    Json json = {{"name", stage_.models[node.model].name}, {"mesh", node.model}};
    if (node.placement != glm::mat4(1.0f)) json["matrix"] = vector_json(&node.placement[0][0], 16);
    document_["nodes"].push_back(json);
  }

  void add_light(const Light& light) {
    Json& lights = document_["extensions"]["KHR_lights_punctual"]["lights"];
    const char* const kinds[] = {"point", "spot", "directional"};
    Json json = {{"name", light.name},
                 {"type", kinds[static_cast<int>(light.kind)]},
                 {"color", to_json(light.color)},
                 {"intensity", light.intensity}};
    if (light.kind == LightKind::spot) {
      json["spot"] = {{"innerConeAngle", light.inner_cone}, {"outerConeAngle", light.outer_cone}};
    }
    lights.push_back(json);
    Json node = {{"name", light.name}, {"translation", to_json(light.position)}};
    if (light.kind != LightKind::point) {
      // A light shines along its own -Z, and pointing() turns +Y.
      const glm::mat4 turn = pointing(-light.direction) * turned(-90.0f, {1.0f, 0.0f, 0.0f});
      node["rotation"] = to_json(glm::normalize(glm::quat_cast(glm::mat3(turn))));
    }
    node["extensions"]["KHR_lights_punctual"]["light"] = lights.size() - 1;
    if (light.radius > 0.0f) {
      const char* const shape = light.kind == LightKind::spot ? "disc" : "sphere";
      node["extras"]["gnomon"]["light"] = {{"shape", shape}, {"radius", light.radius}};
    }
    document_["nodes"].push_back(node);
  }

  void add_camera() {
    document_["cameras"] = Json::array(
        {{{"name", "walk"},
          {"type", "perspective"},
          {"perspective",
           {{"yfov", stage_.vertical_fov}, {"aspectRatio", 16.0 / 9.0}, {"znear", 0.05f}, {"zfar", 200.0f}}}}});
    const CameraKey& first = stage_.flight.front();
    const size_t node = document_["nodes"].size();
    document_["nodes"].push_back({{"name", "walk"},
                                  {"camera", 0},
                                  {"translation", to_json(first.position)},
                                  {"rotation", to_json(first.orientation)}});

    std::vector<float> times;
    std::vector<glm::vec3> positions;
    std::vector<glm::vec4> turns;
    for (const CameraKey& key : stage_.flight) {
      times.push_back(key.seconds);
      positions.push_back(key.position);
      turns.emplace_back(key.orientation.x, key.orientation.y, key.orientation.z, key.orientation.w);
    }
    const Json bounds = {{"min", {times.front()}}, {"max", {times.back()}}};
    const size_t input = add_vectors(times, "SCALAR", 0, bounds);
    const size_t outputs[] = {add_vectors(positions, "VEC3", 0), add_vectors(turns, "VEC4", 0)};
    Json samplers = Json::array(), channels = Json::array();
    for (const size_t output : outputs) {
      const char* const path = samplers.empty() ? "translation" : "rotation";
      channels.push_back({{"sampler", samplers.size()}, {"target", {{"node", node}, {"path", path}}}});
      samplers.push_back({{"input", input}, {"interpolation", "LINEAR"}, {"output", output}});
    }
    document_["animations"] = Json::array({{{"name", "walk"}, {"samplers", samplers}, {"channels", channels}}});
  }

  std::vector<uint8_t> file() const {
    std::string text = document_.dump();
    text.resize((text.size() + 3) / 4 * 4, ' ');
    std::vector<uint8_t> bytes;
    const auto word = [&bytes](size_t value) {
      for (int shift = 0; shift < 32; shift += 8) bytes.push_back(static_cast<uint8_t>(value >> shift));
    };
    word(kMagic), word(kVersion), word(12 + 8 + text.size() + 8 + binary_.size());
    word(text.size()), word(kJsonChunk);
    bytes.insert(bytes.end(), text.begin(), text.end());
    word(binary_.size()), word(kBinaryChunk);
    bytes.insert(bytes.end(), binary_.begin(), binary_.end());
    return bytes;
  }

  const Stage& stage_;
  Json document_;
  std::vector<uint8_t> binary_;
};

}  // namespace

std::vector<uint8_t> to_glb(const Stage& stage) { return Writer(stage).write(); }

}  // namespace gnomon::scenes::assets
