// The reference client's picture: its own G-buffer, shaded by the dissertation's formula with given visibility bits,
//   I = emissive + (base colour / pi) * sum over lights i of k_i * saturate(N . L_i) * I_i + base colour * o * ambient
// where k_i is the bit or, of an area light, the share of its sample points that are seen, I_i is the light's intensity
// at the point (KHR_lights_punctual: inverse square, range window, cone edge), and the ambient radiance goes from one
// value for surfaces that face down to another for those that face up, as the scene states them (scenes::Surroundings; 0
// without). o is the share of the ambient light's segments that nothing near blocks, 1 where masks say nothing of it.
// Base colours are filtered through mip levels. Where no surface is, the scene's sky shows, if it states one.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "common/light_planes.h"
#include "common/result.h"
#include "common/tile_mask.h"
#include "gpu/picture/reprojection.h"
#include "gpu/vulkan_renderer.h"
#include "scenes/motion.h"
#include "scenes/scene.h"

namespace gnomon::gpu {

// RGBA, 8 bits, sRGB; rows from the top.
struct RgbaImage {
  uint32_t width = 0;
  uint32_t height = 0;
  std::vector<uint8_t> rgba;
};

// An image in mapped device memory. Valid until the next call of the object that returned it.
struct RgbaView {
  uint32_t width = 0;
  uint32_t height = 0;
  std::span<const std::byte> rgba;

  RgbaImage copy() const;
};

struct ShadeOptions {
  enum class View { shaded, material, normals };  // material: base colour without light
  enum class Tonemap { clamp, filmic };

  View view = View::shaded;
  Tonemap tonemap = Tonemap::filmic;
  float exposure = 1.0f;               // multiplies radiance before the tone map
  glm::vec3 ambient{0.0f};             // radiance that reaches every surface, beside the scene's own
  glm::vec3 background{0.0f};          // linear; where neither surface nor sky is
  std::optional<uint32_t> only_light;  // shade with this light alone; material: black where it is not seen
  Samples samples = Samples::one;      // of show_predicted and predict alone, see Reprojection::shade
  scenes::SceneTime time{};            // of what moves in the scene, within its period
  LightPlanes planes = {};             // of the masks; without any: one for each light
  // Averages the shares of area lights and of ambient light over the pixels around that show the same surface: an estimate, smoother than
  // what the mask says of each pixel, whose neighbours look at other sample points (shaders/shade.glsl).
  bool soft_filter = false;
};

// One thread. Calls block.
class ReferenceView {
 public:
  // Error: no such device, out of memory, too many lights.
  static Result<std::unique_ptr<ReferenceView>> create(const RendererOptions& options,
                                                       const scenes::ScenePtr& scene);
  ~ReferenceView();

  // Error: `masks` has another size or another number of planes than the scene's lights by options.planes, the size is
  // out of range, or the device is lost.
  Result<RgbaImage> render(const CameraView& camera, uint32_t width, uint32_t height, const TileMaskView& masks,
                           const ShadeOptions& options = {});

  // As render, for a camera whose masks have not arrived: predicts them from those of another camera by reprojection.
  // The scene time is that of `seen`; options.time is ignored. Error: as render.
  Result<RgbaImage> predict(const CameraView& camera, uint32_t width, uint32_t height, const SeenMasks& seen,
                            const ShadeOptions& options = {});
  // As render and predict, without a copy of the image.
  Result<RgbaView> show(const CameraView& camera, uint32_t width, uint32_t height, const TileMaskView& masks,
                        const ShadeOptions& options = {});
  Result<RgbaView> show_predicted(const CameraView& camera, uint32_t width, uint32_t height, const SeenMasks& seen,
                                  const ShadeOptions& options = {});

  // The reprojection that predict uses; it is made at the first call. Error: out of memory.
  Result<Reprojection*> reprojection();

  // Replaces the lights for later pictures. Error: `lights` has another number of lights than the scene.
  Result<void> set_lights(const std::vector<scenes::Light>& lights);

  // An exposure that turns the view's geometric mean luminance, with every light visible everywhere, into a mid grey.
  Result<float> suggest_exposure(const CameraView& camera);

 private:
  class Shader;
  explicit ReferenceView(std::unique_ptr<Shader> shader);
  std::unique_ptr<Shader> shader_;
  std::optional<Reprojection> reprojection_;
};

}  // namespace gnomon::gpu
