// Codecs of others for comparison: general compression of the same tile words, and the standard for bilevel images.
#pragma once

#include <memory>

#include "tests/bench/frame_codec.h"

namespace gnomon::bench {

// zstd at level 3 over all tile words of a frame.
std::unique_ptr<FrameCodec> make_zstd_words();

// JBIG1 (ITU-T T.82, by JBIG-KIT) of each light's picture, in its densest sequential mode: one stripe, typical
// prediction, an adaptive template.
std::unique_ptr<FrameCodec> make_jbig1();

}  // namespace gnomon::bench
