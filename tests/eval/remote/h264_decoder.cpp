#include <algorithm>

#include "tests/eval/remote/av.h"
#include "tests/eval/remote/h264.h"

namespace gnomon::remote {

struct H264Decoder::State {
  av::Codec codec;
  av::Scaler scaler;
  av::Frame frame;
  av::Packet packet;
  std::vector<uint8_t> padded;
  av::Size size;
};

H264Decoder::H264Decoder(std::unique_ptr<State> state) : state_(std::move(state)) {}
H264Decoder::~H264Decoder() = default;
H264Decoder::H264Decoder(H264Decoder&&) noexcept = default;
H264Decoder& H264Decoder::operator=(H264Decoder&&) noexcept = default;

Result<H264Decoder> H264Decoder::create() {
  av::say_nothing();
  const AVCodec* found = avcodec_find_decoder(AV_CODEC_ID_H264);
  if (!found) return Error{"this FFmpeg cannot decode H.264"};
  auto state = std::make_unique<State>();
  state->codec.reset(avcodec_alloc_context3(found));
  state->frame.reset(av_frame_alloc());
  state->packet.reset(av_packet_alloc());
  if (!state->codec || !state->frame || !state->packet) return Error{"out of memory for an H.264 decoder"};
  state->codec->flags |= AV_CODEC_FLAG_LOW_DELAY;
  state->codec->thread_count = 1;  // frame threads would hold pictures back
  if (const int code = avcodec_open2(state->codec.get(), found, nullptr); code < 0)
    return av::failed("H.264 decoder", code);
  return H264Decoder(std::move(state));
}

Result<Picture> H264Decoder::decode(std::span<const uint8_t> access_unit) {
  State& s = *state_;
  s.padded.assign(access_unit.begin(), access_unit.end());
  s.padded.resize(access_unit.size() + AV_INPUT_BUFFER_PADDING_SIZE, 0);
  s.packet->data = s.padded.data();
  s.packet->size = static_cast<int>(access_unit.size());
  if (const int code = avcodec_send_packet(s.codec.get(), s.packet.get()); code < 0)
    return av::failed("decoding a picture", code);
  if (const int code = avcodec_receive_frame(s.codec.get(), s.frame.get()); code < 0)
    return av::failed("decoding a picture", code);
  if (s.frame->format != AV_PIX_FMT_YUV420P) return Error{"a picture that is not 4:2:0 with 8 bits"};
  if (s.size.width != s.frame->width || s.size.height != s.frame->height) {
    s.size = {s.frame->width, s.frame->height};
    auto scaler = av::to_rgba(s.size);
    if (!scaler) return scaler.error();
    s.scaler = std::move(*scaler);
  }
  Picture picture(static_cast<uint32_t>(s.size.width), static_cast<uint32_t>(s.size.height));
  av::convert(*s.scaler, *s.frame, picture);
  return picture;
}

}  // namespace gnomon::remote
