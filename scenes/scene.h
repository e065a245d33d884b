// A loaded scene: plain data, immutable once loaded, shared by every client of every tenant.
//
// Units and axes are glTF's: metres, right-handed, Y up, a camera looks along its own -Z. Colours are linear.
// Every index in a Scene is in range and every number finite: the loader has checked, its users need not.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <memory>
#include <string>
#include <vector>

namespace gnomon::scenes {

inline constexpr uint32_t kNone = 0xffffffff;

enum class Wrap : uint8_t { repeat, mirrored_repeat, clamp_to_edge };

// An image that some material uses as its base colour: RGBA, 8 bits, rows from the top.
struct Texture {
  uint32_t width = 0;
  uint32_t height = 0;
  Wrap wrap_u = Wrap::repeat;
  Wrap wrap_v = Wrap::repeat;
  bool has_alpha = false;  // some texel's alpha is below 255
  std::vector<uint8_t> rgba;
};

// What a surface does to light:
//   opaque  blocks it;
//   mask    blocks it where alpha (texture alpha x base_color.a, nearest texel of level 0) >= alpha_cutoff;
//   blend   is transparent: it blocks nothing and is not in the G-buffer. Clients draw it over the shaded image.
enum class AlphaMode : uint8_t { opaque, mask, blend };

struct Material {
  std::string name;
  glm::vec4 base_color{1.0f};
  glm::vec3 emissive{0.0f};
  uint32_t base_color_texture = kNone;  // index into Scene::textures
  AlphaMode alpha_mode = AlphaMode::opaque;
  float alpha_cutoff = 0.5f;
  // Seen from both sides; else the G-buffer leaves out faces that turn their back. Shadows always count both sides.
  bool double_sided = false;
};

// Triangles of one material within a mesh.
struct Primitive {
  uint32_t material = 0;
  std::vector<glm::vec3> positions;  // object space
  std::vector<glm::vec3> normals;    // empty, or one for each position: unit length
  std::vector<glm::vec2> uvs;        // empty, or one for each position (the base colour texture's set)
  std::vector<glm::uvec3> triangles;
};

struct Mesh {
  std::string name;
  std::vector<Primitive> primitives;
};

// A mesh placed in the world. Meshes used by several nodes are kept once.
struct Instance {
  uint32_t mesh = 0;
  glm::mat4 object_to_world{1.0f};  // of one that moves: at the scene time 0
  uint32_t moved_by = kNone;        // index into Scene::moving_nodes
};

enum class LightType : uint8_t { point, spot, directional };

struct Light {
  std::string name;
  LightType type = LightType::point;
  glm::vec3 position{0.0f};                // point and spot
  glm::vec3 direction{0.0f, -1.0f, 0.0f};  // unit; the way the light shines; spot and directional
  glm::vec3 color{1.0f};                   // linear
  float intensity = 1.0f;                  // candela (point, spot) or lux (directional), as KHR_lights_punctual
  float range = 0.0f;                      // metres; 0: unlimited
  float inner_cone_cos = 1.0f;             // spot: full intensity inside
  float outer_cone_cos = 0.70710678f;      // spot: nothing outside
  uint32_t moved_by = kNone;               // index into Scene::moving_nodes; the place above is then that at time 0
};

// A pose with a symmetric perspective.
struct CameraPose {
  glm::vec3 position{0.0f};
  glm::quat orientation{1.0f, 0.0f, 0.0f, 0.0f};  // (w, x, y, z), unit: camera to world
  float vertical_fov = 0.9f;                      // radians
};

struct Camera {
  std::string name;
  CameraPose rest;
};

// The samples of a glTF animation of one property of one node.
enum class Interpolation : uint8_t { step, linear, cubic_spline };

struct Channel {
  enum class Path : uint8_t { translation, rotation, scale };
  uint32_t node = 0;  // of a camera's path: index into CameraPath::chain
  Path path = Path::translation;
  Interpolation interpolation = Interpolation::linear;
  std::vector<float> times;       // seconds, increasing
  std::vector<glm::vec4> values;  // one for each time; three (in-tangent, value, out-tangent) for cubic_spline
};

struct NodeTransform {
  glm::vec3 translation{0.0f};
  glm::quat rotation{1.0f, 0.0f, 0.0f, 0.0f};
  glm::vec3 scale{1.0f};
  glm::mat4 matrix{1.0f};  // used instead of the three above when has_matrix
  bool has_matrix = false;
};

// A camera's path through the scene: the animations of its node and the node's ancestors, evaluated through pose_at.
struct CameraPath {
  uint32_t camera = 0;  // index into Scene::cameras
  float duration_seconds = 0.0f;
  std::vector<NodeTransform> chain;  // from the root to the camera's node
  std::vector<Channel> channels;
};

// Pose of `path` at `seconds`, clamped to [0, duration].
CameraPose pose_at(const CameraPath& path, float vertical_fov, float seconds);

// A node with meshes, lights or such nodes below it that an animation moves, itself or through an ancestor. See motion.h.
struct MovingNode {
  uint32_t parent = kNone;          // index into Scene::moving_nodes, always a smaller one
  glm::dmat4 parent_to_world{1.0};  // where the parent does not move
  NodeTransform local;
  std::vector<Channel> channels;
};

// A motion that is given to a node beside the animations of its file.
struct NodeMotion {
  enum class Kind : uint8_t { spin, shift };
  std::string node;                     // its name; all nodes of that name
  Kind kind = Kind::spin;               // turns about an axis of its own, or shifts in its parent's axes and back
  glm::vec3 vector{0.0f, 1.0f, 0.0f};   // the axis, or how far
  std::chrono::microseconds period{0};  // of one turn, or of the way there and back
  friend bool operator==(const NodeMotion&, const NodeMotion&) = default;
};

struct Bounds {
  glm::vec3 min{0.0f};
  glm::vec3 max{0.0f};
};

using ContentHash = std::array<uint8_t, 16>;
std::string to_hex(const ContentHash& hash);

struct Scene {
  std::string name;
  std::vector<Texture> textures;
  std::vector<Material> materials;  // never empty
  std::vector<Mesh> meshes;
  std::vector<Instance> instances;
  std::vector<Light> lights;
  std::vector<Camera> cameras;  // never empty: a scene without one gets a view of its bounds
  std::vector<CameraPath> paths;
  std::vector<MovingNode> moving_nodes;
  std::chrono::microseconds period{0};  // after which all moving nodes begin anew
  Bounds bounds;                        // of what is drawn, in the world, wherever it moves
  uint64_t triangle_count = 0;          // in the world: a mesh placed twice counts twice
  // 128 bits over what affects visibility: world triangles in their order, alpha tests, lights and what moves them.
  // Names, colours, cameras and the way a file arranges its triangles into nodes and meshes do not count (see content_hash.h).
  ContentHash content_hash{};

  uint32_t mask_words() const { return (static_cast<uint32_t>(lights.size()) + 31) / 32; }
  uint64_t memory_bytes() const;
};

using ScenePtr = std::shared_ptr<const Scene>;

// A pose on a circle around the scene's middle, looking towards it; one turn takes kOrbitSeconds. Within the bounds
// where a lamp is (an interior), else from outside with all of the scene in view. For scenes without a camera, and
// for those whose camera stands still where one that moves is wanted.
inline constexpr float kOrbitSeconds = 20.0f;
CameraPose orbit_pose(const Scene& scene, float seconds);

}  // namespace gnomon::scenes
