#include "scenes/loader.h"

#include <algorithm>
#include <cmath>
#include <new>
#include <string>
#include <utility>

#include "common/log.h"
#include "scenes/content_hash.h"
#include "scenes/geometry/geometry.h"
#include "scenes/gltf/animations.h"
#include "scenes/gltf/cameras.h"
#include "scenes/gltf/document.h"
#include "scenes/gltf/geometry.h"
#include "scenes/gltf/hierarchy.h"
#include "scenes/gltf/lights.h"
#include "scenes/gltf/materials.h"
#include "scenes/motion.h"

namespace gnomon::scenes {
namespace {

using gltf::Document;
using gltf::PlacedNode;

// Metres. Beyond this, areas and distances leave the range of floats.
constexpr float kFarthest = 1e9f;

// How much of the time is over after each step, on two cores: of five real scenes of 80,000 to 1,050,000 triangles and the
// two built-in ones, the document took 2 to 6% (sponza_crytek), what is before the clusters 10 to 22%. What the caller does
// with the scene, as handing it on to another process, is the rest.
constexpr double kDocumentRead = 0.04, kAssembled = 0.10, kMeasured = 0.12, kClustered = 0.95;

void tell(const OnShare& on_share, double share) {
  if (on_share) on_share(share);
}

// Builds a scene from the placed nodes; each mesh is read when the first node uses it.
class Assembly {
 public:
  Assembly(Document& document, const LoadLimits& limits, const std::vector<NodeMotion>& motions, gltf::Reads reads)
      : document_(document), limits_(limits), motions_(motions), reads_(reads), scene_(std::make_shared<Scene>()) {}

  Result<std::shared_ptr<Scene>> run() {
    auto materials = gltf::read_materials(document_, reads_);
    if (!materials) return materials.error();
    materials_ = std::move(*materials);
    mesh_index_.assign(document_.model.meshes.size(), kUnread);
    const auto nodes = gltf::place_nodes(document_.model, limits_);
    if (!nodes) return nodes.error();
    gltf::Animations animations(document_);
    gltf::MovingNodes moving(document_.model, *nodes, animations, motions_);
    for (uint32_t i = 0; i < nodes->size(); ++i) {
      if (const auto ok = add_mesh((*nodes)[i], i, moving); !ok) return ok.error();
      if (const auto ok = add_light((*nodes)[i], i, moving); !ok) return ok.error();
    }
    if (const auto ok = set_in_motion(moving); !ok) return ok.error();
    auto cameras = gltf::read_cameras(document_, *nodes, animations);
    if (!cameras) return cameras.error();
    scene_->cameras = std::move(cameras->cameras);
    scene_->paths = std::move(cameras->paths);
    scene_->materials = std::move(materials_.materials);
    scene_->textures = std::move(materials_.textures);
    scene_->surroundings = document_.extras.surroundings;
    return std::move(scene_);
  }

 private:
  static constexpr uint32_t kUnread = kNone;
  static constexpr uint32_t kNothingToDraw = kNone - 1;

  Result<void> add_mesh(const PlacedNode& node, uint32_t placed_index, gltf::MovingNodes& moving) {
    const int mesh = document_.model.nodes[static_cast<size_t>(node.node)].mesh;
    if (mesh == -1) return {};
    const auto index = scene_mesh(mesh);
    if (!index) return Error{gltf::node_name(document_.model, node.node) + ": " + index.error().message};
    if (*index == kNothingToDraw) return {};
    const Mesh& placed = scene_->meshes[*index];
    const auto moved_by = moving.find(placed_index);
    if (!moved_by) return moved_by.error();
    scene_->instances.push_back({*index, glm::mat4(node.to_world), *moved_by});
    scene_->triangle_count += gltf::triangle_count(placed);
    if (scene_->instances.size() > limits_.max_instances) return Error{"it has too many instances of meshes"};
    if (scene_->triangle_count > limits_.max_triangles) return Error{"it has too many triangles"};
    return check_extent(placed, scene_->instances.back());
  }

  // Index into Scene::meshes.
  Result<uint32_t> scene_mesh(int mesh) {
    if (mesh < 0 || static_cast<size_t>(mesh) >= mesh_index_.size()) {
      return Error{"mesh " + std::to_string(mesh) + " does not exist"};
    }
    uint32_t& index = mesh_index_[static_cast<size_t>(mesh)];
    if (index != kUnread) return index;
    auto read = gltf::read_mesh(document_, mesh, materials_, limits_.max_triangles - scene_->triangle_count);
    if (!read) return read.error();
    index = kNothingToDraw;
    if (!read->primitives.empty()) {
      index = static_cast<uint32_t>(scene_->meshes.size());
      scene_->meshes.push_back(std::move(*read));
    }
    return index;
  }

  // Tests the corners of the primitives' boxes, because an affine image of a box contains the image of its content.
  Result<void> check_extent(const Mesh& mesh, const Instance& instance) {
    for (const Primitive& primitive : mesh.primitives) {
      Bounds box{primitive.positions.front(), primitive.positions.front()};
      for (const glm::vec3& p : primitive.positions) {
        box.min = glm::min(box.min, p);
        box.max = glm::max(box.max, p);
      }
      for (int corner = 0; corner < 8; ++corner) {
        const glm::vec3 p((corner & 1) ? box.max.x : box.min.x, (corner & 2) ? box.max.y : box.min.y,
                          (corner & 4) ? box.max.z : box.min.z);
        const glm::vec3 w(instance.object_to_world * glm::vec4(p, 1.0f));
        if (!(std::abs(w.x) <= kFarthest && std::abs(w.y) <= kFarthest && std::abs(w.z) <= kFarthest)) {
          return Error{"mesh '" + mesh.name + "' reaches farther than a million kilometres"};
        }
      }
    }
    return {};
  }

  Result<void> add_light(const PlacedNode& node, uint32_t placed_index, gltf::MovingNodes& moving) {
    auto light = gltf::light_at(document_, node);
    if (!light) return light.error();
    if (!*light) return {};
    const auto moved_by = moving.find(placed_index);
    if (!moved_by) return moved_by.error();
    (*light)->moved_by = *moved_by;
    scene_->lights.push_back(std::move(**light));
    if (scene_->lights.size() > limits_.max_lights) {
      return Error{"it has more than " + std::to_string(limits_.max_lights) + " lights"};
    }
    return {};
  }

  // Moves the animated instances and lights to their places at time 0; the file's places are those without animation.
  Result<void> set_in_motion(gltf::MovingNodes& moving) {
    const auto period = moving.fill_period();
    if (!period) return period.error();
    scene_->period = *period;
    scene_->moving_nodes = std::move(moving.nodes());
    if (!moves(*scene_)) return {};
    const std::vector<Instance> moved = moved_instances(*scene_, SceneTime(0));
    auto next = moved.begin();
    for (Instance& instance : scene_->instances) {
      if (instance.moved_by != kNone) instance.object_to_world = (next++)->object_to_world;
    }
    scene_->lights = lights_at(*scene_, scene_->lights, SceneTime(0));
    const Bounds reached = moved_bounds(*scene_, moved_lights_bounds(*scene_));
    for (int axis = 0; axis < 3; ++axis) {
      if (!(reached.min[axis] >= -kFarthest && reached.max[axis] <= kFarthest)) {
        return Error{"its animations move something farther than a million kilometres"};
      }
    }
    return {};
  }

  Document& document_;
  const LoadLimits& limits_;
  const std::vector<NodeMotion>& motions_;
  gltf::Reads reads_;
  std::shared_ptr<Scene> scene_;
  gltf::Materials materials_;
  std::vector<uint32_t> mesh_index_;  // for each mesh of the file: index into Scene::meshes
};

// Warns that skins and morph targets are not animated, so that their vertices stay as stored.
void tell_what_stays_as_stored(const std::filesystem::path& file, const tinygltf::Model& model) {
  const auto warn = [&](std::string_view event, size_t count) {
    if (count > 0) log::warning(event, {{"file", file.string()}, {"count", count}});
  };
  size_t weights = 0;
  for (const tinygltf::Animation& animation : model.animations) {
    for (const auto& channel : animation.channels) weights += channel.target_path == "weights";
  }
  warn("skins are left out: their meshes stay as stored", model.skins.size());
  warn("animated weights are left out: their meshes stay as stored", weights);
}

Result<std::shared_ptr<Scene>> read_scene(const std::filesystem::path& file, const LoadLimits& limits,
                                          const std::vector<NodeMotion>& motions, gltf::Reads reads,
                                          const OnShare& on_share) {
  try {
    auto document = gltf::open_document(file, limits);
    if (!document) return document.error();
    tell(on_share, kDocumentRead);
    tell_what_stays_as_stored(file, document->model);
    return Assembly(*document, limits, motions, reads).run();
  } catch (const std::bad_alloc&) {
    return Error{"there is not enough memory for it"};
  }
}

// Messages quote names from the file, which are untrusted: the result is one line of limited length.
Error about(const std::filesystem::path& file, std::string message) {
  constexpr size_t kLongest = 400;
  if (message.size() > kLongest) message.replace(kLongest, std::string::npos, "...");
  std::replace_if(
      message.begin(), message.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }, '?');
  return Error{file.string() + ": " + message};
}

Result<std::shared_ptr<Scene>> load(const std::filesystem::path& file, const LoadLimits& limits,
                                    const std::vector<NodeMotion>& motions, gltf::Reads reads,
                                    const OnShare& on_share) {
  auto read = read_scene(file, limits, motions, reads, on_share);
  if (!read) return about(file, read.error().message);
  tell(on_share, kAssembled);
  Scene& scene = **read;
  scene.name = file.stem().string();
  const Extent extent = measure(scene);
  scene.bounds = extent.bounds;
  scene.content_hash = extent.hash;
  if (scene.cameras.empty()) scene.cameras.push_back({"bounds", orbit_pose(scene, 0.0f)});
  return read;
}

}  // namespace

Result<ScenePtr> load_scene(const std::filesystem::path& file, const LoadLimits& limits,
                            const std::vector<NodeMotion>& motions) {
  auto scene = load(file, limits, motions, gltf::Reads::colours, {});
  if (!scene) return scene.error();
  return ScenePtr(std::move(*scene));
}

Result<ScenePtr> load_with_geometry(const std::filesystem::path& file, const LoadLimits& limits,
                                    const std::vector<NodeMotion>& motions, Colours colours,
                                    const OnShare& on_share) {
  auto scene = load(file, limits, motions,
                    colours == Colours::encoded ? gltf::Reads::encoded : gltf::Reads::alpha_tests, on_share);
  if (!scene) return scene.error();
  const uint64_t needed = predicted_bytes(**scene);
  if (limits.max_scene_bytes != 0 && needed > limits.max_scene_bytes) {
    return about(file, "it needs " + std::to_string((needed >> 20) + 1) + " MiB of memory, and a scene may have " +
                           std::to_string(limits.max_scene_bytes >> 20) + " MiB now");
  }
  (*scene)->geometry =
      std::make_shared<const Geometry>(make_geometry(**scene, part_of(on_share, kMeasured, kClustered)));
  return ScenePtr(std::move(*scene));
}

}  // namespace gnomon::scenes
