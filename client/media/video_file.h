// Pictures one after the other into a video file, through the program ffmpeg: H.264 in the container that the name's
// ending says.
#pragma once

#include <filesystem>
#include <memory>

#include "client/media/png.h"
#include "common/result.h"

namespace gnomon::client {

struct VideoOptions {
  double fps = 30;
  int quality = 16;  // libx264's constant rate factor: 0 loses nothing but chroma's resolution, 51 is the worst
};

// One thread. The first picture sets the size; an odd last row or column is cut. A file of that name is replaced.
class VideoFile {
 public:
  // Error: no such folder.
  static Result<VideoFile> create(const std::filesystem::path& file, const VideoOptions& options);
  ~VideoFile();  // without close(), what there is so far
  VideoFile(VideoFile&&) noexcept;
  VideoFile& operator=(VideoFile&&) noexcept;

  // Waits while ffmpeg is behind. Error: there is no program ffmpeg, or it has ended (it says why on stderr).
  Result<void> add(const Picture& picture);
  // Waits for the file's end. Error: nothing was added, or ffmpeg failed.
  Result<void> close();

 private:
  struct State;
  explicit VideoFile(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace gnomon::client
