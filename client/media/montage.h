// Pictures made of pictures: the shown region of a traced one, and the dissertation's Figure 2.
#pragma once

#include <vector>

#include "client/media/png.h"

namespace gnomon::client {

Picture copied(const PictureView& view);
// Part of a picture, which holds it.
Picture crop(const Picture& whole, uint32_t left, uint32_t top, uint32_t width, uint32_t height);
PictureView crop(const PictureView& whole, uint32_t left, uint32_t top, uint32_t width, uint32_t height);

// Both of the same height.
Picture beside(const Picture& left, const Picture& right);

// How far each channel is off, `gain` times, in black where nothing is. Both of the same size.
Picture difference(const Picture& a, const Picture& b, uint32_t gain);

// Panels, each scaled down to fit, in columns left of the shaded picture. Without panels: the shaded picture.
Picture montage(const std::vector<Picture>& panels, const Picture& shaded);

}  // namespace gnomon::client
