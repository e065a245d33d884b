#include <cmath>

#include "tests/eval/remote/av.h"
#include "tests/eval/remote/h264.h"

namespace gnomon::remote {

struct H264Encoder::State {
  H264Options options;
  av::Codec codec;
  av::Scaler scaler;
  av::Frame frame;
  av::Packet packet;
  int64_t pictures = 0;
};

H264Encoder::H264Encoder(std::unique_ptr<State> state) : state_(std::move(state)) {}
H264Encoder::~H264Encoder() = default;
H264Encoder::H264Encoder(H264Encoder&&) noexcept = default;
H264Encoder& H264Encoder::operator=(H264Encoder&&) noexcept = default;

Result<H264Encoder> H264Encoder::create(const H264Options& options) {
  auto state = std::make_unique<State>();
  state->options = options;
  const av::Size size = av::even_size(options.width, options.height);
  auto codec = av::h264_encoder(size, options.fps);
  if (!codec) return codec.error();
  state->codec = std::move(*codec);
  state->codec->max_b_frames = 0;
  state->codec->gop_size = -1;  // key pictures come when asked for
  av_opt_set(state->codec->priv_data, "preset", options.preset, 0);
  av_opt_set(state->codec->priv_data, "tune", "zerolatency", 0);
  av_opt_set(state->codec->priv_data, "forced-idr", "1", 0);

  H264Encoder encoder(std::move(state));
  encoder.set_rate(options.bit_per_s);
  State& made = *encoder.state_;
  if (const int code = avcodec_open2(made.codec.get(), nullptr, nullptr); code < 0)
    return av::failed("H.264 encoder", code);
  auto scaler = av::to_yuv(size);
  if (!scaler) return scaler.error();
  made.scaler = std::move(*scaler);
  auto frame = av::yuv_frame(size);
  if (!frame) return frame.error();
  made.frame = std::move(*frame);
  made.packet.reset(av_packet_alloc());
  if (!made.packet) return Error{"out of memory for a video packet"};
  return encoder;
}

// libx264's wrapper looks at these before every picture.
void H264Encoder::set_rate(double bit_per_s) {
  AVCodecContext& codec = *state_->codec;
  codec.bit_rate = std::llround(bit_per_s);
  codec.rc_max_rate = codec.bit_rate;
  codec.rc_buffer_size = static_cast<int>(std::lround(2 * bit_per_s / state_->options.fps));
}

Result<std::vector<uint8_t>> H264Encoder::encode(const Picture& picture, bool key) {
  State& s = *state_;
  if (picture.width != s.options.width || picture.height != s.options.height)
    return Error{"a picture of another size than the encoder's"};
  if (const int code = av_frame_make_writable(s.frame.get()); code < 0) return av::failed("a video frame", code);
  av::convert(*s.scaler, picture, *s.frame);
  s.frame->pts = s.pictures++;
  s.frame->pict_type = key ? AV_PICTURE_TYPE_I : AV_PICTURE_TYPE_NONE;
  if (const int code = avcodec_send_frame(s.codec.get(), s.frame.get()); code < 0)
    return av::failed("encoding a picture", code);
  if (const int code = avcodec_receive_packet(s.codec.get(), s.packet.get()); code < 0)
    return av::failed("encoding a picture", code);
  std::vector<uint8_t> unit(s.packet->data, s.packet->data + s.packet->size);
  av_packet_unref(s.packet.get());
  return unit;
}

}  // namespace gnomon::remote
