// Pictures made of pictures: the shown region of a traced one, and the dissertation's Figure 2.
#pragma once

#include <vector>

#include "client/png.h"

namespace gnomon::client {

// The middle of a traced picture, without its prediction border. `width` and `height` do not exceed the picture's.
Picture crop_centre(const Picture& traced, uint32_t width, uint32_t height);

// Panels, each scaled down to fit, in columns left of the shaded picture. Without panels: the shaded picture.
Picture montage(const std::vector<Picture>& panels, const Picture& shaded);

}  // namespace gnomon::client
