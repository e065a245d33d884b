// The pictures that a flight writes: a few frames spread over the path, shaded, and what each light sees.
#pragma once

#include <filesystem>
#include <vector>

#include "client/media/montage.h"

namespace gnomon::client {

class Gallery {
 public:
  // Creates the folder. At most `pictures` of `frames` are kept. `lights`: their names, with which panels are labelled.
  static Result<Gallery> open(const std::filesystem::path& folder, uint32_t frames, uint32_t pictures,
                              std::vector<std::string> lights);

  // Whether this frame is to be kept: the first one at or after each of the chosen steps, as some are never answered.
  bool wants(uint32_t index) const;

  // Writes frame_NNNN.png (shaded) and lights_NNNN.png (a panel for each light beside it).
  Result<void> add(uint32_t index, const Picture& shaded, const std::vector<Picture>& seen_by_lights);

  // Writes KIND_NNNN_lightL.png for each of `pictures`.
  Result<void> add_views(uint32_t index, const char* kind, const std::vector<Picture>& pictures);

  const std::vector<std::filesystem::path>& files() const { return files_; }

 private:
  std::filesystem::path folder_;
  uint32_t frames_ = 0;
  uint32_t pictures_ = 0;
  uint32_t taken_ = 0;
  std::vector<std::string> lights_;
  std::vector<std::filesystem::path> files_;
};

}  // namespace gnomon::client
