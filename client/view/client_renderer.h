// The client's part of a frame: rasterises its copy of the scene at the masks' moment, and shades it with the masks and
// lights that it received, by reprojection if these are of an earlier camera. Tiles that did not arrive are reprojected
// from the previous masks.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "client/media/png.h"
#include "client/thin_client.h"
#include "gpu/picture/reference_view.h"
#include "scenes/scene.h"

namespace gnomon::client {

// One thread. Calls block.
class ClientRenderer {
 public:
  struct Options {
    std::string device;                        // as gpu::RendererOptions::device; if empty, the best one
    gpu::Samples samples = gpu::Samples::one;  // of each pixel of shade()
    bool soft_filter = false;                  // gpu::ShadeOptions::soft_filter
    bool soft_accumulate = false;  // shows counts as means over the newest masks and up to three before them
  };
  static Result<ClientRenderer> create(const scenes::ScenePtr& scene, const ViewSize& size, const Options& options);

  // The picture, without the border, in the memory that the device wrote: valid until the next call. The exposure is
  // chosen for the first frame and kept.
  Result<PictureView> draw(const Showing& showing, gpu::Samples samples);
  Result<Picture> shade(const Showing& showing);  // the same, copied, with the samples of the options
  // A picture for each light: base colours where it shines, black elsewhere.
  Result<std::vector<Picture>> seen_by_lights(const Showing& showing);

  // Measures how wrong a prediction was, for mode `auto` to learn from. The masks shown are kept until those of the
  // then newest camera have arrived; these are predicted from the kept ones and compared. Then the next masks are kept.
  // nullopt as long as the masks that are waited for have not arrived, which is the usual case.
  struct Outcome {
    protocol::CameraView earlier, later;
    double error = 0;  // share of the picture's bits
  };
  Result<std::optional<Outcome>> outcome(const Showing& showing);

  uint64_t covered_words() const { return covered_words_; }  // words that did not arrive and were reprojected

 private:
  using ReceivedPtr = std::shared_ptr<const ReceivedMasks>;
  struct Trial {
    gpu::SeenMasks seen;
    ReceivedPtr masks;   // the same
    uint32_t index = 0;  // of the camera whose masks are waited for
  };

  Result<PictureView> render(const Showing& showing, gpu::ShadeOptions options);
  Result<void> take(const ReceivedPtr& received);
  Result<void> take_lights(const std::vector<protocol::LightInfo>& lights);
  Result<void> cover(ReceivedMasks& received);
  void keep_for_later(const AssembledFrame& next, bool same_lights);
  Result<const gpu::SeenMasks*> seen();

  std::unique_ptr<gpu::ReferenceView> view_;
  ViewSize size_;
  gpu::Samples samples_ = gpu::Samples::one;
  bool soft_filter_ = false;
  bool soft_accumulate_ = false;
  std::vector<protocol::LightInfo> lights_;  // in use by the view; if empty, the scene's own
  std::optional<float> exposure_;
  ReceivedPtr masks_;                    // the newest, their missing tiles reprojected
  std::optional<gpu::SeenMasks> seen_;   // of masks_, rasterised when needed
  std::vector<gpu::SeenMasks> earlier_;  // before masks_, the newest first, of the same lights and planes
  std::optional<Trial> trial_;
  uint64_t covered_words_ = 0;
};

}  // namespace gnomon::client
