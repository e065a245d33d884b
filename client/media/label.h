// Short texts in pictures.
#pragma once

#include <string>

#include "client/media/png.h"

namespace gnomon::client {

// Writes one line of ASCII in white on a dark ground whose upper left corner lies at (left, top). What would reach
// beyond `right` or the picture is cut. `scale`: of letters that are 7 pixels high.
void write_label(Picture& picture, uint32_t left, uint32_t top, uint32_t right, const std::string& text,
                 uint32_t scale);

// The scale at which labels can be read in a picture of this height.
inline uint32_t label_scale(uint32_t height) { return height < 360 ? 1 : height / 360; }

}  // namespace gnomon::client
