#include "tests/eval/remote/av.h"

#include <cmath>

namespace gnomon::remote::av {
namespace {

Result<Scaler> scaler(const Size& size, AVPixelFormat from, AVPixelFormat to) {
  Scaler made(sws_getContext(size.width, size.height, from, size.width, size.height, to,
                             SWS_BILINEAR | SWS_ACCURATE_RND | SWS_FULL_CHR_H_INP | SWS_FULL_CHR_H_INT, nullptr,
                             nullptr, nullptr));
  if (!made) return Error{"FFmpeg cannot convert pictures of this size"};
  const int* bt709 = sws_getCoefficients(SWS_CS_ITU709);
  const int rgb_range = 1, yuv_range = 0;
  const bool from_rgb = from == AV_PIX_FMT_RGBA;
  sws_setColorspaceDetails(made.get(), bt709, from_rgb ? rgb_range : yuv_range, bt709,
                           from_rgb ? yuv_range : rgb_range, 0, 1 << 16, 1 << 16);
  return made;
}

}  // namespace

Error failed(const std::string& what, int code) {
  char text[AV_ERROR_MAX_STRING_SIZE] = {};
  av_strerror(code, text, sizeof text);
  return Error{what + ": " + text};
}

Size even_size(uint32_t width, uint32_t height) {
  return {static_cast<int>(width & ~1u), static_cast<int>(height & ~1u)};
}

Result<Scaler> to_yuv(const Size& size) { return scaler(size, AV_PIX_FMT_RGBA, AV_PIX_FMT_YUV420P); }
Result<Scaler> to_rgba(const Size& size) { return scaler(size, AV_PIX_FMT_YUV420P, AV_PIX_FMT_RGBA); }

Result<Frame> yuv_frame(const Size& size) {
  Frame frame(av_frame_alloc());
  if (!frame) return Error{"out of memory for a video frame"};
  frame->format = AV_PIX_FMT_YUV420P;
  frame->width = size.width;
  frame->height = size.height;
  if (const int code = av_frame_get_buffer(frame.get(), 0); code < 0) return failed("a video frame", code);
  return frame;
}

void convert(SwsContext& scaler, const Picture& from, AVFrame& to) {
  const uint8_t* const planes[] = {from.rgba.data()};
  const int strides[] = {static_cast<int>(4 * from.width)};
  sws_scale(&scaler, planes, strides, 0, to.height, to.data, to.linesize);
}

void convert(SwsContext& scaler, const AVFrame& from, Picture& to) {
  uint8_t* const planes[] = {to.rgba.data()};
  const int strides[] = {static_cast<int>(4 * to.width)};
  sws_scale(&scaler, from.data, from.linesize, 0, from.height, planes, strides);
}

void say_nothing() { av_log_set_level(AV_LOG_QUIET); }

Result<Codec> h264_encoder(const Size& size, double fps) {
  say_nothing();
  const AVCodec* codec = avcodec_find_encoder_by_name("libx264");
  if (!codec) return Error{"this FFmpeg has no libx264"};
  if (size.width < 2 || size.height < 2) return Error{"a video's picture has at least 2x2 pixels"};
  Codec made(avcodec_alloc_context3(codec));
  if (!made) return Error{"out of memory for an H.264 encoder"};
  made->width = size.width;
  made->height = size.height;
  made->pix_fmt = AV_PIX_FMT_YUV420P;
  made->time_base = {1000, static_cast<int>(std::lround(fps * 1000))};
  made->framerate = {made->time_base.den, made->time_base.num};
  made->color_range = AVCOL_RANGE_MPEG;
  made->colorspace = AVCOL_SPC_BT709;
  made->color_primaries = AVCOL_PRI_BT709;
  made->color_trc = AVCOL_TRC_IEC61966_2_1;
  return made;
}

}  // namespace gnomon::remote::av
