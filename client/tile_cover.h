// What stands in for tiles that did not arrive: the last picture's bits at their place, as they were most likely the
// same; before there was one, light (the assembler's own choice), as no false shadow is better than one.
#pragma once

#include "client/frame_assembler.h"

namespace gnomon::client {

class TileCover {
 public:
  // Fills what is missing in `frame`, and remembers the whole for the next one. Frames come in the order in which they
  // are shown. Returns how many words (tiles of one light) were filled from the last picture.
  size_t cover(AssembledFrame& frame) {
    size_t covered = 0;
    if (!frame.complete() && last_grid_ == frame.grid) {
      for (size_t word = 0; word < frame.words.size(); ++word) {
        if (frame.arrived[word]) continue;
        frame.words[word] = last_[word];
        ++covered;
      }
    }
    last_ = frame.words;
    last_grid_ = frame.grid;
    return covered;
  }

 private:
  TileGrid last_grid_{};
  std::vector<uint64_t> last_;
};

}  // namespace gnomon::client
