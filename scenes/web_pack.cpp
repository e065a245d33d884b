#include "scenes/web_pack.h"

#include <algorithm>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "scenes/geometry/geometry.h"
#include "scenes/web_pack_moving.h"

namespace gnomon::scenes {
namespace {

using json = nlohmann::ordered_json;

constexpr std::string_view kMagic = "GNPACK01";
constexpr size_t kHeadBytes = 16;
constexpr size_t kAlignment = 16;
constexpr uint64_t kMostBytes = (uint64_t{1} << 31) - 1;  // of one ArrayBuffer

uint64_t aligned(uint64_t offset) { return (offset + kAlignment - 1) / kAlignment * kAlignment; }

// A binary32 as the binary64 that is the same number: it is written so that a reader gets exactly this one.
template <class T>
json list(const T& values, glm::length_t count = T::length()) {
  json out = json::array();
  for (glm::length_t i = 0; i < count; ++i) out.push_back(static_cast<double>(values[i]));
  return out;
}

json list(const glm::quat& q) { return list(glm::vec4(q.x, q.y, q.z, q.w)); }

template <class T>
json list(const glm::mat<4, 4, T>& m) {
  json out = json::array();
  for (int i = 0; i < 16; ++i) out.push_back(static_cast<double>(m[i / 4][i % 4]));
  return out;
}

// What follows the JSON. The bytes are borrowed until they are written; offsets count from the end of the JSON.
class Sections {
 public:
  template <class T>
  json add(const std::vector<T>& values) {
    return add(std::as_bytes(std::span(values)), {});
  }
  // `first`, and `then` right behind it.
  template <class T>
  json add(const std::vector<T>& first, const std::vector<T>& then) {
    return add(std::as_bytes(std::span(first)), std::as_bytes(std::span(then)));
  }
  json add(std::span<const std::byte> first, std::span<const std::byte> then) {
    const uint64_t offset = aligned(size_);
    pieces_.emplace_back(offset, first);
    pieces_.emplace_back(offset + first.size(), then);
    size_ = offset + first.size() + then.size();
    return {{"offset", offset}, {"bytes", first.size() + then.size()}};
  }

  uint64_t size() const { return size_; }
  void write(std::span<std::byte> into) const {
    for (const auto& [offset, bytes] : pieces_) {
      if (!bytes.empty()) std::memcpy(&into[offset], bytes.data(), bytes.size());
    }
  }

 private:
  std::vector<std::pair<uint64_t, std::span<const std::byte>>> pieces_;
  uint64_t size_ = 0;
};

void shift_offsets(json& value, uint64_t by) {
  for (auto& [key, member] : value.items()) {
    if (key == "offset") {
      member = member.get<uint64_t>() + by;
    } else if (member.is_structured()) {
      shift_offsets(member, by);
    }
  }
}

const char* name_of(Wrap wrap) {
  switch (wrap) {
    case Wrap::repeat: return "repeat";
    case Wrap::mirrored_repeat: return "mirrored_repeat";
    case Wrap::clamp_to_edge: break;
  }
  return "clamp_to_edge";
}

const char* name_of(AlphaMode mode) {
  switch (mode) {
    case AlphaMode::opaque: return "opaque";
    case AlphaMode::mask: return "mask";
    case AlphaMode::blend: break;
  }
  return "blend";
}

const char* name_of(Channel::Path path) {
  switch (path) {
    case Channel::Path::translation: return "translation";
    case Channel::Path::rotation: return "rotation";
    case Channel::Path::scale: break;
  }
  return "scale";
}

const char* name_of(Interpolation interpolation) {
  switch (interpolation) {
    case Interpolation::step: return "step";
    case Interpolation::linear: return "linear";
    case Interpolation::cubic_spline: break;
  }
  return "cubic_spline";
}

json index_or_none(uint32_t index) { return index == kNone ? json(-1) : json(index); }

class Pack {
 public:
  explicit Pack(const Scene& scene) : scene_(scene), geometry_(geometry_of(scene)), moving_(moving_part(scene)) {
    // All vertices stand in one list, the moving ones behind the others.
    const auto resting = static_cast<uint32_t>(geometry_->mesh.positions.size());
    for (glm::uvec3& triangle : moving_.mesh.triangles) triangle += resting;
  }

  Result<std::vector<std::byte>> make() {
    for (const Texture& texture : scene_.textures) {
      if (texture.encoded.empty()) return Error{"scene '" + scene_.name + "' was read without its pictures"};
    }
    const json relative = describe();
    if (sections_.size() + relative.size() > kMostBytes) return too_large();
    // Where the sections begin depends on the length of the JSON, which says where they are.
    uint64_t start = kHeadBytes;
    std::string text;
    for (;;) {
      json absolute = relative;
      shift_offsets(absolute, start);
      text = absolute.dump(-1, ' ', false, json::error_handler_t::replace);
      const uint64_t needed = aligned(kHeadBytes + text.size());
      if (needed <= start) break;
      start = needed;
    }
    if (start + sections_.size() > kMostBytes) return too_large();
    text.resize(start - kHeadBytes, ' ');
    std::vector<std::byte> pack(start + sections_.size());
    std::memcpy(pack.data(), kMagic.data(), kMagic.size());
    const auto json_bytes = static_cast<uint32_t>(text.size());
    std::memcpy(&pack[kMagic.size()], &json_bytes, sizeof json_bytes);
    std::memcpy(&pack[kHeadBytes], text.data(), text.size());
    sections_.write(std::span(pack).subspan(start));
    return pack;
  }

 private:
  Error too_large() const { return {"scene '" + scene_.name + "' is larger than browsers can hold"}; }

  json describe() {
    const WorldMesh& mesh = geometry_->mesh;
    json out;
    out["name"] = scene_.name;
    out["content_hash"] = to_hex(scene_.content_hash);
    out["vertices"] = mesh.positions.size() + moving_.mesh.positions.size();
    out["triangles"] = mesh.triangles.size() + moving_.mesh.triangles.size();
    out["resting"] = {{"vertices", mesh.positions.size()}, {"triangles", mesh.triangles.size()}};
    out["bounds"] = {{"min", list(scene_.bounds.min)}, {"max", list(scene_.bounds.max)}};
    out["period_us"] = scene_.period.count();
    out["surroundings"] = surroundings();
    out["cameras"] = cameras();
    out["camera_paths"] = camera_paths();
    out["lights"] = json::array();
    for (const Light& light : scene_.lights) out["lights"].push_back(light.name);
    out["materials"] = materials();
    out["groups"] = groups();
    out["sections"] = {{"positions", sections_.add(mesh.positions, moving_.mesh.positions)},
                       {"normals", sections_.add(mesh.normals, moving_.mesh.normals)},
                       {"uvs", sections_.add(mesh.uvs, moving_.mesh.uvs)},
                       {"triangles", sections_.add(mesh.triangles, moving_.mesh.triangles)},
                       {"triangle_materials", sections_.add(mesh.materials, moving_.mesh.materials)}};
    out["moving"] = {{"nodes", nodes()}, {"instances", instances()}, {"lights", moving_lights()}};
    out["textures"] = textures();
    return out;
  }

  json surroundings() const {
    const Surroundings& s = scene_.surroundings;
    return {{"ambient_above", list(s.ambient_above)},
            {"ambient_below", list(s.ambient_below)},
            {"has_sky", s.has_sky},
            {"sky_zenith", list(s.sky_zenith)},
            {"sky_horizon", list(s.sky_horizon)},
            {"sky_ground", list(s.sky_ground)},
            {"sky_clouds", static_cast<double>(s.sky_clouds)}};
  }

  json cameras() const {
    json out = json::array();
    for (const Camera& camera : scene_.cameras) {
      out.push_back({{"name", camera.name},
                     {"position", list(camera.rest.position)},
                     {"orientation", list(camera.rest.orientation)},
                     {"vertical_fov", static_cast<double>(camera.rest.vertical_fov)}});
    }
    return out;
  }

  json camera_paths() {
    json out = json::array();
    for (const CameraPath& path : scene_.paths) {
      json chain = json::array();
      for (const NodeTransform& node : path.chain) chain.push_back(transform(node));
      json moved = json::array();
      for (const Channel& c : path.channels) {
        moved.push_back(channel(c));
        moved.back()["node"] = c.node;
      }
      out.push_back({{"camera", path.camera},
                     {"duration_s", static_cast<double>(path.duration_seconds)},
                     {"chain", std::move(chain)},
                     {"channels", std::move(moved)}});
    }
    return out;
  }

  json materials() const {
    json out = json::array();
    for (const Material& material : scene_.materials) {
      out.push_back({{"name", material.name},
                     {"base_color", list(material.base_color)},
                     {"emissive", list(material.emissive)},
                     {"texture", index_or_none(material.base_color_texture)},
                     {"alpha_mode", name_of(material.alpha_mode)},
                     {"alpha_cutoff", static_cast<double>(material.alpha_cutoff)},
                     {"double_sided", material.double_sided}});
    }
    return out;
  }

  json textures() {
    json out = json::array();
    std::map<std::string_view, json> known;  // files in the pack: several textures may be made of one
    for (const Texture& texture : scene_.textures) {
      const std::string_view bytes(reinterpret_cast<const char*>(texture.encoded.data()), texture.encoded.size());
      const auto [place, is_new] = known.try_emplace(bytes);
      if (is_new) place->second = sections_.add(texture.encoded);
      json entry = {{"width", texture.width},
                    {"height", texture.height},
                    {"wrap_u", name_of(texture.wrap_u)},
                    {"wrap_v", name_of(texture.wrap_v)},
                    {"has_alpha", texture.has_alpha},
                    {"type", texture.encoded[0] == 0xff ? "image/jpeg" : "image/png"}};
      entry.update(place->second);
      out.push_back(std::move(entry));
    }
    return out;
  }

  json groups() const {
    json out = json::array();
    const auto add = [&](const ClusterGroup& group, size_t from) {
      if (group.triangle_count == 0) return;
      out.push_back({{"first_triangle", from + group.first_triangle},
                     {"triangles", group.triangle_count},
                     {"masked", group.masked},
                     {"double_sided", group.double_sided}});
    };
    for (const ClusterGroup& group : geometry_->clusters.occluders) add(group, 0);
    for (const ClusterGroup& group : geometry_->clusters.others) add(group, 0);
    for (const ClusterGroup& group : moving_.groups) add(group, geometry_->mesh.triangles.size());
    return out;
  }

  json nodes() {
    json out = json::array();
    for (const MovingNode& node : scene_.moving_nodes) {
      json entry = {{"parent", index_or_none(node.parent)}, {"parent_to_world", list(node.parent_to_world)}};
      entry.update(transform(node.local));
      entry["channels"] = json::array();
      for (const Channel& c : node.channels) entry["channels"].push_back(channel(c));
      out.push_back(std::move(entry));
    }
    return out;
  }

  json instances() const {
    json out = json::array();
    for (const MovingInstance& instance : moving_.instances) {
      out.push_back({{"node", instance.node},
                     {"first_vertex", geometry_->mesh.positions.size() + instance.first_vertex},
                     {"vertices", instance.vertices},
                     {"first_triangle", geometry_->mesh.triangles.size() + instance.first_triangle},
                     {"triangles", instance.triangles},
                     {"flat", instance.flat}});
    }
    return out;
  }

  json moving_lights() const {
    json out = json::array();
    for (size_t i = 0; i < scene_.lights.size(); ++i) {
      const uint32_t node = scene_.lights[i].moved_by;
      if (node != kNone) out.push_back({{"light", i}, {"node", node}});
    }
    return out;
  }

  static json transform(const NodeTransform& node) {
    if (node.has_matrix) return {{"matrix", list(node.matrix)}};
    return {
        {"translation", list(node.translation)}, {"rotation", list(node.rotation)}, {"scale", list(node.scale)}};
  }

  json channel(const Channel& c) {
    return {{"path", name_of(c.path)},
            {"interpolation", name_of(c.interpolation)},
            {"times", sections_.add(c.times)},
            {"values", sections_.add(c.values)}};
  }

  const Scene& scene_;
  const GeometryPtr geometry_;
  MovingPart moving_;
  Sections sections_;
};

}  // namespace

Result<std::vector<std::byte>> web_pack(const Scene& scene) { return Pack(scene).make(); }

}  // namespace gnomon::scenes
