// A scene that a generator builds: materials, models placed by nodes, lights and the flight of one camera.
//
// It is plain data with indices, in the order in which it is written to the file.
#pragma once

#include <cstdint>
#include <deque>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <initializer_list>
#include <map>
#include <string>
#include <vector>

#include "scenes/assets/mesh.h"
#include "scenes/assets/textures.h"

namespace gnomon::scenes::assets {

inline constexpr uint32_t kNoImage = 0xffffffff;

struct Material {
  std::string name;
  glm::vec3 base_color{0.8f};  // linear
  float roughness = 0.8f;
  float metallic = 0.0f;
  glm::vec3 emissive{0.0f};
  uint32_t cutout = kNoImage;  // image whose alpha cuts holes (alphaMode MASK), seen from both sides
  // Image that colours the surface, and how much of the surface it spans; meshes get coordinates as they are written.
  uint32_t texture = kNoImage;
  float texture_metres = 1.0f;
};

// A part of a model: its triangles of one material.
struct Part {
  uint32_t material = 0;
  Mesh mesh;
};

struct Model {
  std::string name;
  std::deque<Part> parts;  // a deque, so that references returned by in() stay valid

  // The mesh of `material` in this model, which is added if there is none.
  Mesh& in(uint32_t material);
};

struct Node {
  uint32_t model = 0;
  glm::mat4 placement{1.0f};
};

enum class LightKind { point, spot, directional };

struct Light {
  std::string name;
  LightKind kind = LightKind::point;
  glm::vec3 position{0.0f};
  glm::vec3 direction{0.0f, -1.0f, 0.0f};  // unit; the way the light shines
  glm::vec3 color{1.0f};
  float intensity = 1.0f;                      // candela; lux if directional
  float inner_cone = 0.0f, outer_cone = 0.7f;  // radians from the axis
  // Of its extent, from which its shadows are soft: a sphere; of a spot, a disc across its axis. No geometry is nearer.
  float radius = 0.0f;
};

// What surrounds the scene, as `extras.gnomon` states it (docs/scenes.md); radiances, linear.
struct Surroundings {
  glm::vec3 ambient_above{0.0f}, ambient_below{0.0f};
  glm::vec3 zenith{0.0f}, horizon{0.0f}, ground{0.0f};
  float clouds = 0.0f;
};

struct CameraKey {
  float seconds = 0;
  glm::vec3 position{0.0f};
  glm::quat orientation{1.0f, 0.0f, 0.0f, 0.0f};
};

struct Stage {
  std::string name;
  std::vector<std::vector<uint8_t>> images;  // PNG files
  std::vector<Material> materials;
  std::vector<Model> models;
  std::vector<Node> nodes;
  std::vector<Light> lights;
  Surroundings surroundings;
  float vertical_fov = 0.9f;  // radians
  std::vector<CameraKey> flight;

  uint32_t add(Material material);
  uint32_t add(Model model);
  uint32_t matte(const std::string& name, glm::vec3 srgb);  // adds a plain material of that sRGB colour
  // Gives the materials that pattern, which spans `metres`; on the whole they keep their colours.
  void dress(std::initializer_list<uint32_t> dressed, Pattern pattern, float metres);
  void place(uint32_t model, const glm::mat4& placement = glm::mat4(1.0f));
  void place(Model model, const glm::mat4& placement = glm::mat4(1.0f));

  uint64_t triangle_count() const;  // in the world: a model placed twice counts twice

 private:
  struct Made {
    uint32_t image;
    glm::vec3 mean;
  };
  std::map<Pattern, Made> made_;
};

glm::vec3 linear(glm::vec3 srgb);
glm::vec3 linear(uint32_t rgb);  // 0xrrggbb

// A closed flight: the eye moves at constant speed along a smooth loop through `eyes` and looks at a point on the loop
// through `targets`, one for each eye. There are 30 keys per second; the last has the pose of the first.
std::vector<CameraKey> fly(const std::vector<glm::vec3>& eyes, const std::vector<glm::vec3>& targets,
                           float seconds);

}  // namespace gnomon::scenes::assets
