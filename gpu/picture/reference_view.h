// The reference client's picture: its own G-buffer, shaded by the dissertation's formula with given visibility bits,
//   I = emissive + (base colour / pi) * sum over lights i of k_i * saturate(N . L_i) * I_i
// where I_i is the light's intensity at the point (KHR_lights_punctual: inverse square, range window, cone edge).
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

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

// The same where the device left it. Valid until its maker's next call.
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
  glm::vec3 ambient{0.0f};             // radiance that reaches every surface; 0 keeps the formula
  glm::vec3 background{0.0f};          // linear; where no surface is
  std::optional<uint32_t> only_light;  // shade with this light alone; material: black where it is not seen
  scenes::SceneTime time{};            // of what moves in the scene, within its period
};

// One thread. Calls block.
class ReferenceView {
 public:
  // Error: no such device, out of memory, too many lights.
  static Result<std::unique_ptr<ReferenceView>> create(const RendererOptions& options,
                                                       const scenes::ScenePtr& scene);
  ~ReferenceView();

  // `masks` is of the same size and of the scene's lights. Error: it is not; size out of range; device lost.
  Result<RgbaImage> render(const CameraView& camera, uint32_t width, uint32_t height, const TileMaskView& masks,
                           const ShadeOptions& options = {});

  // The same for a camera whose masks have not come: with those of another one, by reprojection. The time is that of
  // `seen`, not of the options. Error: as render.
  Result<RgbaImage> predict(const CameraView& camera, uint32_t width, uint32_t height, const SeenMasks& seen,
                            const ShadeOptions& options = {});
  // The same, not copied.
  Result<RgbaView> show(const CameraView& camera, uint32_t width, uint32_t height, const TileMaskView& masks,
                        const ShadeOptions& options = {});
  Result<RgbaView> show_predicted(const CameraView& camera, uint32_t width, uint32_t height, const SeenMasks& seen,
                                  const ShadeOptions& options = {});

  // Made at the first call. Error: out of memory.
  Result<Reprojection*> reprojection();

  // The lights of pictures from now on, as many as the scene has. Error: another number.
  Result<void> set_lights(const std::vector<scenes::Light>& lights);

  // An exposure that suits this view: its mean luminance, every light seen everywhere, becomes a mid grey.
  Result<float> suggest_exposure(const CameraView& camera);

 private:
  class Shader;
  explicit ReferenceView(std::unique_ptr<Shader> shader);
  std::unique_ptr<Shader> shader_;
  std::optional<Reprojection> reprojection_;
};

}  // namespace gnomon::gpu
