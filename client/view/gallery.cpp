#include "client/view/gallery.h"

#include <algorithm>
#include <cstdio>
#include <utility>

namespace gnomon::client {
namespace fs = std::filesystem;
namespace {

std::string numbered(const char* kind, uint32_t index) {
  char name[40];
  std::snprintf(name, sizeof name, "%s_%04u.png", kind, index);
  return name;
}

}  // namespace

Result<Gallery> Gallery::open(const fs::path& folder, uint32_t frames, uint32_t pictures,
                              std::vector<std::string> lights) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return Error{"cannot make folder " + folder.string() + ": " + error.message()};
  Gallery gallery;
  gallery.folder_ = folder;
  gallery.frames_ = frames;
  gallery.lights_ = std::move(lights);
  gallery.pictures_ = std::min(pictures, frames);
  return gallery;
}

bool Gallery::wants(uint32_t index) const {
  // The steps lie in the middle of equal parts of the path.
  return taken_ < pictures_ && index >= (2 * uint64_t{taken_} + 1) * frames_ / (2 * pictures_);
}

Result<void> Gallery::add(uint32_t index, const Picture& shaded, const std::vector<Picture>& seen_by_lights) {
  ++taken_;
  const fs::path frame_file = folder_ / numbered("frame", index);
  const fs::path lights_file = folder_ / numbered("lights", index);
  if (auto written = write_png(frame_file, shaded); !written) return written;
  if (auto written = write_png(lights_file, montage(seen_by_lights, shaded, lights_)); !written) return written;
  files_.insert(files_.end(), {frame_file, lights_file});
  return {};
}

Result<void> Gallery::add_views(uint32_t index, const char* kind, const std::vector<Picture>& pictures) {
  for (size_t light = 0; light < pictures.size(); ++light) {
    char name[64];
    std::snprintf(name, sizeof name, "%s_%04u_light%zu.png", kind, index, light);
    const fs::path file = folder_ / name;
    if (auto written = write_png(file, pictures[light]); !written) return written;
    files_.push_back(file);
  }
  return {};
}

}  // namespace gnomon::client
