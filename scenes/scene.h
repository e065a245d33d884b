// A loaded scene: plain data, immutable once loaded, shared by all clients of all tenants.
//
// Units and axes are glTF's: metres, right-handed, Y up, a camera looks along its own -Z. Colours are linear.
// Every index in a Scene is in range and every number is finite: the loader checks this, so that users need not.
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

// An image that a material uses as its base colour. Either `rgba` or `encoded` may be empty: whoever loads the scene
// says what it needs (loader.h). What an alpha test reads always has its texels.
struct Texture {
  uint32_t width = 0;
  uint32_t height = 0;
  Wrap wrap_u = Wrap::repeat;
  Wrap wrap_v = Wrap::repeat;
  bool has_alpha = false;             // some texel's alpha is below 255; false without texels
  std::vector<uint8_t> rgba;          // 8 bits, rows from the top
  std::vector<uint8_t> encoded = {};  // the image's own file, PNG or JPEG, for whoever decodes it elsewhere
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
  // Visible from both sides; otherwise the G-buffer leaves out back faces. Both sides always cast shadows.
  bool double_sided = false;
};

// Triangles of one material within a mesh.
struct Primitive {
  uint32_t material = 0;
  std::vector<glm::vec3> positions;  // object space
  std::vector<glm::vec3> normals;    // empty, or one for each position, of unit length
  std::vector<glm::vec2> uvs;        // empty, or one for each position (the base colour texture's set)
  std::vector<glm::uvec3> triangles;
};

struct Mesh {
  std::string name;
  std::vector<Primitive> primitives;
};

// A mesh placed in the world. A mesh that several nodes use is stored once.
struct Instance {
  uint32_t mesh = 0;
  glm::mat4 object_to_world{1.0f};  // at the scene time 0, if the instance moves
  uint32_t moved_by = kNone;        // index into Scene::moving_nodes
};

enum class LightType : uint8_t { point, spot, directional };

enum class LightShape : uint8_t { point, sphere, disc, rectangle };

// The extent of a point or spot light, from which its shadows are soft. It does not change what the light gives: colour,
// intensity and cone are those of a point in its middle.
struct LightArea {
  LightShape shape = LightShape::point;
  // From the middle to the edge, in the world. disc and rectangle: along the node's own X and Y; sphere: both of the
  // radius's length.
  glm::vec3 u{0.0f};
  glm::vec3 v{0.0f};

  // No point of the light is farther from its middle.
  float reach() const {
    return shape == LightShape::rectangle ? glm::length(glm::abs(u) + glm::abs(v)) : glm::length(u);
  }
  friend bool operator==(const LightArea&, const LightArea&) = default;
};

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
  LightArea area;                          // point and spot
  uint32_t moved_by = kNone;               // index into Scene::moving_nodes; the members above are then of time 0
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

// As in glTF 2.0, appendix C.
enum class Interpolation : uint8_t { step, linear, cubic_spline };

// The keys of a glTF animation of one property of one node.
struct Channel {
  enum class Path : uint8_t { translation, rotation, scale };
  uint32_t node = 0;  // index into CameraPath::chain; unused in a MovingNode
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

// A camera's path through the scene: the animations of its node and the node's ancestors. pose_at evaluates it.
struct CameraPath {
  uint32_t camera = 0;  // index into Scene::cameras
  float duration_seconds = 0.0f;
  std::vector<NodeTransform> chain;  // from the root to the camera's node
  std::vector<Channel> channels;
};

// The pose of `path` at `seconds`, which is clamped to [0, duration]. `vertical_fov`: radians.
CameraPose pose_at(const CameraPath& path, float vertical_fov, float seconds);

// A node that an animation moves, itself or through an ancestor, and that carries a mesh or a light, itself or through
// a descendant. See motion.h.
struct MovingNode {
  uint32_t parent = kNone;          // index into Scene::moving_nodes, less than this node's own
  glm::dmat4 parent_to_world{1.0};  // used if `parent` is kNone
  NodeTransform local;
  std::vector<Channel> channels;
};

// A motion of a node that is configured beside the animations of the file.
struct NodeMotion {
  enum class Kind : uint8_t { spin, shift };
  std::string node;                     // applies to all nodes of that name
  Kind kind = Kind::spin;               // turns about an axis of its own, or shifts in its parent's axes and back
  glm::vec3 vector{0.0f, 1.0f, 0.0f};   // the axis, or the offset in metres
  std::chrono::microseconds period{0};  // of one turn, or of one shift there and back
  friend bool operator==(const NodeMotion&, const NodeMotion&) = default;
};

struct Bounds {
  glm::vec3 min{0.0f};
  glm::vec3 max{0.0f};
};

// What surrounds a scene, for whoever draws it: `extras.gnomon` of the file's scene (docs/scenes.md). Radiances, linear,
// in the units in which a white surface under a light of E lux has the radiance E / pi. All zero if the file says none.
struct Surroundings {
  glm::vec3 ambient_above{0.0f};  // what reaches surfaces that face up, and those that face down
  glm::vec3 ambient_below{0.0f};
  float ambient_reach = 0.0f;  // metres within which geometry occludes ambient light; 0: by the scene's size
  bool has_sky = false;
  glm::vec3 sky_zenith{0.0f};
  glm::vec3 sky_horizon{0.0f};
  glm::vec3 sky_ground{0.0f};  // below the horizon
  float sky_clouds = 0.0f;     // share of the sky that clouds cover, 0 to 1
};

using ContentHash = std::array<uint8_t, 16>;
std::string to_hex(const ContentHash& hash);

// Derived from a scene, see geometry/geometry.h.
struct Geometry;
using GeometryPtr = std::shared_ptr<const Geometry>;

struct Scene {
  std::string name;
  std::vector<Texture> textures;
  std::vector<Material> materials;  // never empty
  std::vector<Mesh> meshes;
  std::vector<Instance> instances;
  std::vector<Light> lights;
  std::vector<Camera> cameras;  // never empty: a file without a camera gets a view of the scene's bounds
  std::vector<CameraPath> paths;
  std::vector<MovingNode> moving_nodes;
  Surroundings surroundings;
  std::chrono::microseconds period{0};  // after which all animations restart
  Bounds bounds;                        // of what is drawn, in the world, at all scene times
  uint64_t triangle_count = 0;          // in the world: a mesh placed twice counts twice
  // 128 bits over what affects visibility: world triangles in their order, alpha tests, lights and what moves them.
  // Names, colours, cameras and the way a file arranges its triangles into nodes and meshes do not affect it (see
  // content_hash.h).
  ContentHash content_hash{};
  // What devices need of the resting instances, if whoever read the scene has made it already; else nullptr.
  GeometryPtr geometry;

  uint32_t mask_words() const { return (static_cast<uint32_t>(lights.size()) + 31) / 32; }
  uint64_t memory_bytes() const;  // of the host, the geometry included
};

using ScenePtr = std::shared_ptr<const Scene>;

// A pose on a circle around the scene's middle, looking towards it; one turn takes kOrbitSeconds. The circle lies
// within the bounds if a lamp does (an interior), else outside with all of the scene in view. It is used for scenes
// without a camera, and where a moving camera is wanted but the scene's does not move.
inline constexpr float kOrbitSeconds = 20.0f;
CameraPose orbit_pose(const Scene& scene, float seconds);

}  // namespace gnomon::scenes
