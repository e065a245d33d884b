#include "client/media/png.h"

#include <png.h>

#include <cassert>

namespace gnomon::client {
namespace {

// libpng's simplified interface, which returns errors as text instead of by longjmp.
png_image rgba_image(uint32_t width, uint32_t height) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = width;
  image.height = height;
  image.format = PNG_FORMAT_RGBA;
  return image;
}

}  // namespace

Result<void> write_png(const std::filesystem::path& file, const Picture& picture) {
  assert(picture.rgba.size() == size_t{4} * picture.width * picture.height);
  png_image image = rgba_image(picture.width, picture.height);
  if (!png_image_write_to_file(&image, file.c_str(), 0, picture.rgba.data(), 0, nullptr)) {
    return Error{"cannot write " + file.string() + ": " + image.message};
  }
  return {};
}

Result<Picture> read_png(const std::filesystem::path& file) {
  png_image image = rgba_image(0, 0);
  if (!png_image_begin_read_from_file(&image, file.c_str())) {
    return Error{"cannot read " + file.string() + ": " + image.message};
  }
  image.format = PNG_FORMAT_RGBA;
  Picture picture(image.width, image.height);
  if (!png_image_finish_read(&image, nullptr, picture.rgba.data(), 0, nullptr)) {
    return Error{"cannot read " + file.string() + ": " + image.message};
  }
  return picture;
}

}  // namespace gnomon::client
