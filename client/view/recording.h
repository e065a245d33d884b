// Records a flight as a video: what was shown, alone or compared with what it should have been.
#pragma once

#include <filesystem>
#include <memory>
#include <string_view>

#include "client/media/video_file.h"
#include "client/view/ground_truth_renderer.h"

namespace gnomon::client {

enum class RecordView {
  shown,
  side_by_side,  // shown left, traced by this machine right, each labelled
  difference,    // between the two, times 4
};
Result<RecordView> parse_record_view(std::string_view name);  // "side-by-side"

class Recording {
 public:
  struct Options {
    std::filesystem::path file;
    RecordView view = RecordView::shown;
    double fps = 30;
    ClientRenderer::Options own;  // as those of the pictures shown
  };
  static Result<Recording> open(const Options& options, const scenes::ScenePtr& scene, const ViewSize& size);

  Result<void> add(const Showing& showing, const Picture& shaded);
  Result<void> close();

 private:
  Recording(RecordView view, VideoFile video) : view_(view), video_(std::move(video)) {}

  RecordView view_;
  VideoFile video_;
  std::unique_ptr<GroundTruthRenderer> ideal_;  // null if only `shown` is recorded
};

}  // namespace gnomon::client
