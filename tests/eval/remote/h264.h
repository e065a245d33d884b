// H.264 without delay: a picture in, an access unit out, and back.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "client/media/png.h"
#include "common/result.h"

namespace gnomon::remote {

using client::Picture;

struct H264Options {
  uint32_t width = 0;  // an odd last row or column is cut
  uint32_t height = 0;
  double fps = 30;                  // what the bit rate is spread over
  double bit_per_s = 4e6;           // at first
  const char* preset = "veryfast";  // libx264's
};

// One thread. Errors: libx264 is missing, or out of memory.
class H264Encoder {
 public:
  static Result<H264Encoder> create(const H264Options& options);
  ~H264Encoder();
  H264Encoder(H264Encoder&&) noexcept;
  H264Encoder& operator=(H264Encoder&&) noexcept;

  // From the next picture on. No picture may take more than two intervals' share of it.
  void set_rate(double bit_per_s);
  // `key`: this one shall decode without those before. Of the size that was said.
  Result<std::vector<uint8_t>> encode(const Picture& picture, bool key = false);

 private:
  struct State;
  explicit H264Encoder(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

// One thread. Takes access units in the encoder's order, the first a key picture; total: any bytes give a picture or
// an error.
class H264Decoder {
 public:
  static Result<H264Decoder> create();
  ~H264Decoder();
  H264Decoder(H264Decoder&&) noexcept;
  H264Decoder& operator=(H264Decoder&&) noexcept;

  Result<Picture> decode(std::span<const uint8_t> access_unit);

 private:
  struct State;
  explicit H264Decoder(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace gnomon::remote
