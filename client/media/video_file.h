// Writes pictures as the frames of a video file, through the program ffmpeg: H.264 in the container that the file
// name's extension selects.
#pragma once

#include <filesystem>
#include <memory>

#include "client/media/png.h"
#include "common/result.h"

namespace gnomon::client {

struct VideoOptions {
  double fps = 30;
  int quality = 16;  // libx264's constant rate factor: 0 loses only chroma's resolution, 51 is the worst
};

// One thread. The first picture sets the size; an odd last row or column is cut. A file of that name is replaced.
class VideoFile {
 public:
  // Error: there is no such folder.
  static Result<VideoFile> create(const std::filesystem::path& file, const VideoOptions& options);
  ~VideoFile();  // without close(), ends the file after the pictures so far
  VideoFile(VideoFile&&) noexcept;
  VideoFile& operator=(VideoFile&&) noexcept;

  // Blocks while ffmpeg is behind. Error: there is no program ffmpeg, it has ended (it says why on stderr), or the
  // picture has another size than the first.
  Result<void> add(const Picture& picture);
  // Blocks until the file is complete. Error: nothing was added, or ffmpeg failed.
  Result<void> close();

 private:
  struct State;
  explicit VideoFile(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace gnomon::client
