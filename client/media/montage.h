// Pictures composed of pictures: the shown region of a traced one, and the dissertation's Figure 2.
#pragma once

#include <string>
#include <vector>

#include "client/media/png.h"

namespace gnomon::client {

Picture copied(const PictureView& view);
// Part of a picture; a view borrows from it. Precondition: the part lies within the picture.
Picture crop(const Picture& whole, uint32_t left, uint32_t top, uint32_t width, uint32_t height);
PictureView crop(const PictureView& whole, uint32_t left, uint32_t top, uint32_t width, uint32_t height);

// Both pictures in one. Precondition: they have the same height.
Picture beside(const Picture& left, const Picture& right);

// The absolute difference of each channel, times `gain`: black where they are equal. Precondition: they have the same
// size.
Picture difference(const Picture& a, const Picture& b, uint32_t gain);

// The panels, each scaled down to fit and labelled with its name, in columns left of the shaded picture. Without panels:
// the shaded picture. `names`: one for each panel, or none.
Picture montage(const std::vector<Picture>& panels, const Picture& shaded,
                const std::vector<std::string>& names = {});

}  // namespace gnomon::client
