// What owns FFmpeg's C objects, and its errors as ours. For the sources of this folder only.
#pragma once

extern "C" {
#include <libavcodec/avcodec.h>

#include <libavutil/opt.h>
#include <libswscale/swscale.h>
}

#include <memory>
#include <string>

#include "client/media/png.h"
#include "common/result.h"

namespace gnomon::remote::av {

using client::Picture;

struct Free {
  void operator()(AVCodecContext* c) const { avcodec_free_context(&c); }
  void operator()(AVFrame* f) const { av_frame_free(&f); }
  void operator()(AVPacket* p) const { av_packet_free(&p); }
  void operator()(SwsContext* s) const { sws_freeContext(s); }
};
using Codec = std::unique_ptr<AVCodecContext, Free>;
using Frame = std::unique_ptr<AVFrame, Free>;
using Packet = std::unique_ptr<AVPacket, Free>;
using Scaler = std::unique_ptr<SwsContext, Free>;

// FFmpeg's libraries write to stderr otherwise; what matters comes back as an error.
void say_nothing();
Error failed(const std::string& what, int code);

// Pictures to BT.709 4:2:0 and back. Chroma covers two by two pixels, so that an odd last row or column is cut.
struct Size {
  int width = 0;
  int height = 0;
};
Size even_size(uint32_t width, uint32_t height);
Result<Scaler> to_yuv(const Size& size);
Result<Scaler> to_rgba(const Size& size);
Result<Frame> yuv_frame(const Size& size);
void convert(SwsContext& scaler, const Picture& from, AVFrame& to);
void convert(SwsContext& scaler, const AVFrame& from, Picture& to);

// An H.264 encoder that is not open yet: of this size, rate and colour.
Result<Codec> h264_encoder(const Size& size, double fps);

}  // namespace gnomon::remote::av
