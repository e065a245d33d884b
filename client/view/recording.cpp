#include "client/view/recording.h"

#include "client/media/label.h"
#include "client/media/montage.h"

namespace gnomon::client {
namespace {

constexpr uint32_t kGain = 4;  // of differences

}  // namespace

Result<RecordView> parse_record_view(std::string_view name) {
  if (name == "shown") return RecordView::shown;
  if (name == "side-by-side") return RecordView::side_by_side;
  if (name == "difference") return RecordView::difference;
  return Error{std::string(name) + ": no view to record; shown, side-by-side or difference is"};
}

Result<Recording> Recording::open(const Options& options, const scenes::ScenePtr& scene, const ViewSize& size) {
  auto video = VideoFile::create(options.file, {.fps = options.fps});
  if (!video) return video.error();
  Recording recording(options.view, std::move(*video));
  if (options.view == RecordView::shown) return recording;
  auto ideal = GroundTruthRenderer::create(scene, size, options.own);
  if (!ideal) return ideal.error();
  recording.ideal_ = std::move(*ideal);
  return recording;
}

Result<void> Recording::add(const Showing& showing, const Picture& shaded) {
  if (!ideal_) return video_.add(shaded);
  const auto ideal = ideal_->picture(showing.camera, scenes::SceneTime(showing.seen->mask.moment.scene_time_us));
  if (!ideal) return ideal.error();
  if (view_ == RecordView::difference) return video_.add(difference(shaded, *ideal, kGain));
  Picture both = beside(shaded, *ideal);
  const uint32_t scale = label_scale(both.height), right = both.width - ideal->width;
  write_label(both, 0, 0, shaded.width, "shown: masks from the server", scale);
  write_label(both, right, 0, both.width, "to compare: traced here", scale);
  return video_.add(both);
}

Result<void> Recording::close() { return video_.close(); }

}  // namespace gnomon::client
