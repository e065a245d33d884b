#include "tests/eval/remote/remote_client.h"

#include <map>

#include "client/net/arrival_report.h"
#include "client/stream/slice_recovery.h"
#include "tests/eval/remote/h264.h"
#include "tests/eval/remote/remote_server.h"
#include "tests/eval/remote/unit_stream.h"

namespace gnomon::remote {
namespace {

using namespace std::chrono_literals;
using protocol::DatagramKind;

constexpr Nanoseconds kPatience = 2s;  // for what is under way at the end

class Flight {
 public:
  Flight(const client::CameraPath& path, const FlightPlan& plan, H264Decoder decoder)
      : path_(path),
        plan_(plan),
        decoder_(std::move(decoder)),
        camera_timer_(loop_, [this] { send_camera(); }),
        report_timer_(loop_, [this] { report(); }) {}

  Result<FlightResult> run();

 private:
  void send_camera();
  void report();
  void receive(const protocol::Opened& datagram, TimePoint arrived);
  void add_slice(std::span<const uint8_t> body);
  void show(const Unit& unit);
  bool all_sent() const { return sent_ == plan_.frames; }

  const client::CameraPath& path_;
  const FlightPlan& plan_;
  client::Loop loop_;
  H264Decoder decoder_;
  std::unique_ptr<client::DataChannel> channel_;
  client::Timer camera_timer_, report_timer_;
  client::ArrivalReport arrivals_;
  client::SliceRecovery recovery_;
  UnitAssembler units_;
  uint32_t recovered_ = 0;
  uint32_t sent_ = 0;
  TimePoint started_{}, last_sent_{}, last_shown_{};
  FrameId last_decoded_;
  std::map<FrameId, TimePoint> asked_;
  std::vector<uint8_t> body_;
  FlightResult result_;
};

Result<FlightResult> Flight::run() {
  auto seal = std::make_unique<protocol::Seal>(kSession, protocol::CipherId::aes_128_gcm, plan_.secrets,
                                               protocol::Side::client);
  auto channel = client::DataChannel::open(loop_, plan_.server, std::move(seal),
                                           [this](const auto& datagram, TimePoint at) { receive(datagram, at); });
  if (!channel) return channel.error();
  channel_ = std::move(*channel);
  started_ = last_shown_ = Clock::now();
  result_.screen.started = started_;
  result_.screen.rate_hz = plan_.rate_hz;
  result_.screen.steps = plan_.frames;
  send_camera();
  while (!all_sent() || (!asked_.empty() && Clock::now() < last_sent_ + kPatience))
    loop_.run_until(Clock::now() + 20ms, [] { return false; });
  result_.seconds = to_seconds(last_shown_ - started_);
  result_.received_bytes = channel_->counters().received_bytes;
  return std::move(result_);
}

void Flight::send_camera() {
  const TimePoint now = Clock::now();
  protocol::CameraUpdate update;
  update.camera = client::view_of(path_.at(plan_.from_s + sent_ / plan_.rate_hz), plan_.size);
  update.frame = FrameId{++sent_};
  update.client_time_us = static_cast<uint64_t>(to_microseconds(now.time_since_epoch()));
  update.have = units_.broken() ? FrameId{} : last_decoded_;
  body_.clear();
  protocol::append_camera_update(body_, update);
  channel_->send(DatagramKind::camera_update, body_);
  asked_[update.frame] = now;
  last_sent_ = now;
  if (!all_sent()) camera_timer_.arm(started_ + Nanoseconds(static_cast<int64_t>(sent_ * 1e9 / plan_.rate_hz)));
}

void Flight::report() {
  const TimePoint now = Clock::now();
  if (arrivals_.due_at() <= now) {
    protocol::Feedback feedback = arrivals_.take(now);
    feedback.recovered = recovered_;
    body_.clear();
    protocol::append_feedback(body_, feedback);
    channel_->send(DatagramKind::feedback, body_);
  }
  if (arrivals_.due_at() != TimePoint::max()) report_timer_.arm(arrivals_.due_at());
}

void Flight::receive(const protocol::Opened& datagram, TimePoint arrived) {
  arrivals_.received(datagram.header.sequence, arrived);
  report_timer_.arm(arrivals_.due_at());
  if (datagram.header.kind == DatagramKind::frame_slice) add_slice(datagram.body);
  if (datagram.header.kind == DatagramKind::frame_parity) {
    const auto parity = protocol::decode_parity(datagram.body);
    if (!parity) return;
    for (const auto& body : recovery_.add_parity(*parity)) {
      ++recovered_;
      add_slice(body);
    }
  }
  while (const auto unit = units_.take()) show(*unit);
}

void Flight::add_slice(std::span<const uint8_t> body) {
  const auto slice = protocol::decode_frame_slice(body);
  if (!slice) return;
  units_.add(*slice);
  for (const auto& rebuilt : recovery_.add_slice(slice->header, body)) {
    ++recovered_;
    add_slice(rebuilt);
  }
}

// Cameras before it will not be answered any more.
void Flight::show(const Unit& unit) {
  const TimePoint begun = Clock::now();
  auto picture = decoder_.decode(unit.bytes);
  const auto asked = asked_.find(unit.frame);
  if (!picture || asked == asked_.end()) {
    ++result_.not_decoded;
    return;
  }
  last_decoded_ = unit.frame;
  last_shown_ = Clock::now();
  result_.decode.add(last_shown_ - begun);
  result_.response.add(last_shown_ - asked->second);
  result_.screen.pictures.push_back({unit.frame.value - 1, last_shown_, std::move(*picture)});
  asked_.erase(asked_.begin(), std::next(asked));
}

}  // namespace

Result<FlightResult> fly(const client::CameraPath& path, const FlightPlan& plan) {
  auto decoder = H264Decoder::create();
  if (!decoder) return decoder.error();
  return Flight(path, plan, std::move(*decoder)).run();
}

}  // namespace gnomon::remote
