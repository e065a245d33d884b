// The client's own half of a frame: rasterises its copy of the scene, as it is at the masks' moment, and shades it with
// the masks and lights it received; where these are of an earlier camera, by reprojection. Tiles that did not arrive
// are reprojected from the masks before.
#pragma once

#include <memory>
#include <string>

#include "client/media/png.h"
#include "client/thin_client.h"
#include "gpu/picture/reference_view.h"
#include "scenes/scene.h"

namespace gnomon::client {

// One thread. Calls block.
class OwnView {
 public:
  // `device`: as gpu::RendererOptions::device; empty: the best one.
  static Result<OwnView> create(const scenes::ScenePtr& scene, const ViewSize& size, const std::string& device);

  // The picture, without the border, where the device left it: valid until the next call. The exposure is chosen at the
  // first frame and stays.
  Result<PictureView> draw(const Showing& showing);
  Result<Picture> shade(const Showing& showing);  // the same, copied
  // What each light sees: base colours, black elsewhere.
  Result<std::vector<Picture>> seen_by_lights(const Showing& showing);

  // How wrong a prediction was (mode `auto` learns from it): masks that are shown are kept until those of the camera of
  // that moment have come, which are predicted from them and compared; then the next are. Mostly: nothing to tell yet.
  struct Outcome {
    protocol::CameraView earlier, later;
    double error = 0;  // share of the picture's bits
  };
  Result<std::optional<Outcome>> outcome(const Showing& showing);

  uint64_t covered_words() const { return covered_words_; }  // that did not arrive

 private:
  using ReceivedPtr = std::shared_ptr<const Received>;
  struct Trial {
    gpu::SeenMasks seen;
    ReceivedPtr masks;   // the same
    uint32_t index = 0;  // whose masks are awaited
  };

  Result<PictureView> render(const Showing& showing, gpu::ShadeOptions options);
  Result<void> take(const ReceivedPtr& received);
  Result<void> take_lights(const std::vector<protocol::LightInfo>& lights);
  Result<void> cover(Received& received);
  Result<const gpu::SeenMasks*> seen();

  std::unique_ptr<gpu::ReferenceView> view_;
  ViewSize size_;
  std::vector<protocol::LightInfo> lights_;  // that the view has; empty: the scene's own
  std::optional<float> exposure_;
  ReceivedPtr masks_;                   // the newest, complete: missing tiles covered
  std::optional<gpu::SeenMasks> seen_;  // the same, rasterised when needed
  std::optional<Trial> trial_;
  uint64_t covered_words_ = 0;
};

}  // namespace gnomon::client
