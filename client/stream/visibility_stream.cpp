#include "client/stream/visibility_stream.h"

#include <algorithm>
#include <utility>

namespace gnomon::client {
namespace {

constexpr Nanoseconds kRepeatInterval = std::chrono::milliseconds(250);

StreamOptions with_features(StreamOptions options) {
  using namespace protocol;
  options.connect.hello.features |= kFeatureMoments | kFeatureFeedback | kFeatureParity | kFeatureSizes;
  if (options.keep_references) options.connect.hello.features |= kFeatureReferences;
  if (!options.samples.is_hard()) options.connect.hello.features |= kFeatureSoft;
  options.connect.hello.samples = to_byte(options.samples);
  return options;
}

}  // namespace

StreamCounters& StreamCounters::operator+=(const StreamCounters& other) {
  asked += other.asked;
  complete += other.complete;
  incomplete += other.incomplete;
  superseded += other.superseded;
  unanswered += other.unanswered;
  lost_slices += other.lost_slices;
  duplicate_slices += other.duplicate_slices;
  late_slices += other.late_slices;
  rebuilt_slices += other.rebuilt_slices;
  unreadable_slices += other.unreadable_slices;
  resumed += other.resumed;
  moved += other.moved;
  invalid_slices += other.invalid_slices;
  return *this;
}

StreamCounters& StreamCounters::operator-=(const StreamCounters& other) {
  asked -= other.asked;
  complete -= other.complete;
  incomplete -= other.incomplete;
  superseded -= other.superseded;
  unanswered -= other.unanswered;
  lost_slices -= other.lost_slices;
  duplicate_slices -= other.duplicate_slices;
  late_slices -= other.late_slices;
  rebuilt_slices -= other.rebuilt_slices;
  unreadable_slices -= other.unreadable_slices;
  resumed -= other.resumed;
  moved -= other.moved;
  invalid_slices -= other.invalid_slices;
  return *this;
}

VisibilityStream::VisibilityStream(Loop& loop, StreamOptions options, Events events)
    : options_(with_features(std::move(options))),
      events_(std::move(events)),
      upkeep_timer_(loop, [this] { upkeep(Clock::now()); }),
      report_timer_(loop, [this] { report_arrivals(); }),
      connection_(loop, options_.connect,
                  {.opened = [this] { start(); },
                   .resumed = [this] { continue_resumed(); },
                   .message = [this](const protocol::Message& message) { on_message(message); },
                   .datagram = [this](const protocol::Opened& datagram,
                                      TimePoint arrived) { on_datagram(datagram, arrived); },
                   .closed =
                       [this](const Error& error) {
                         upkeep_timer_.disarm();
                         report_timer_.disarm();
                         if (events_.closed) events_.closed(error);
                       }}) {}

void VisibilityStream::start() {
  const auto& welcome = connection_.welcome();
  adopt(welcome);
  const auto silence = std::chrono::milliseconds(welcome.silence_timeout_ms);
  repeat_interval_ = silence.count() > 0 ? std::min<Nanoseconds>(kRepeatInterval, silence / 4) : kRepeatInterval;
  upkeep(Clock::now());
  if (events_.opened) events_.opened();
}

void VisibilityStream::adopt(const protocol::Welcome& welcome) {
  scene_ = welcome.scene;
  lights_.clear();
  lights_.add(welcome.lights_version, scene_.lights);
  restart_with(MaskShape(welcome));
}

// A camera in flight is requested again: its answer may be lost, or begun by a process that did not end it.
void VisibilityStream::continue_resumed() {
  ++counters_.resumed;
  assembler_.reset();
  recovery_ = {};
  adopt(connection_.welcome());
  first_of_grid_ = FrameId{requested_.newest().value + 1};
  if (in_flight() == 0) return;
  const protocol::CameraView camera = newest_.camera;
  ask(camera, std::chrono::microseconds(newest_.display_deadline_us), newest_index_);
}

// Frames requested before this may have another grid. Their slices can still be used if they say of which shape they are.
void VisibilityStream::restart_with(MaskShape shape) {
  const MaskShape before = std::exchange(shape_, std::move(shape));
  if (assembler_ && assembler_->grid() == shape_.grid() && assembler_->planes() == shape_.planes()) return;
  const bool tell_apart = assembler_ && shape_.tells_apart(before);
  assembler_.emplace(shape_.grid(), shape_.planes());
  if (connection_.welcome().features & protocol::kFeatureReferences) assembler_->keep_references();
  if (!tell_apart) first_of_grid_ = FrameId{requested_.newest().value + 1};
}

void VisibilityStream::on_message(const protocol::Message& message) {
  if (std::holds_alternative<protocol::Waiting>(message)) {
    if (events_.message) events_.message(message);
    return;
  }
  MaskShape shape = shape_;
  if (const auto* degraded = std::get_if<protocol::Degraded>(&message)) {
    shape.take(*degraded);
  } else if (const auto* scene = std::get_if<protocol::SceneChanged>(&message)) {
    scene_ = scene->scene;
    shape.take(*scene);
    lights_.clear();
  } else if (const auto* lights = std::get_if<protocol::LightsChanged>(&message)) {
    scene_.lights = lights->lights;
    shape.take(*lights);
    lights_.add(lights->version, scene_.lights);
  }
  restart_with(std::move(shape));
  if (events_.message) events_.message(message);
}

FrameId VisibilityStream::ask(const protocol::CameraView& camera, Nanoseconds display_deadline, uint32_t index) {
  const TimePoint now = Clock::now();
  newest_.frame = requested_.add(camera, now, index);
  newest_index_ = index;
  newest_.camera = camera;
  newest_.client_time_us = static_cast<uint64_t>(to_microseconds(now.time_since_epoch()));
  newest_.display_deadline_us = static_cast<uint32_t>(to_microseconds(display_deadline));
  ++counters_.asked;
  send_newest();
  return newest_.frame;
}

void VisibilityStream::send_newest() {
  if (!has(protocol::kFeatureFeedback)) acks_.fill(newest_);
  newest_.have = assembler_->newest_reference();
  body_.clear();
  protocol::append_camera_update(body_, newest_);
  connection_.send(protocol::DatagramKind::camera_update, body_);
  last_sent_ = Clock::now();
}

bool VisibilityStream::has(uint64_t feature) const { return (connection_.welcome().features & feature) != 0; }

void VisibilityStream::on_datagram(const protocol::Opened& datagram, TimePoint arrived) {
  if (has(protocol::kFeatureFeedback)) {
    arrivals_.received(datagram.header.sequence, arrived);
    plan_report();
  }
  if (connection_.resuming()) return;  // the datagram may assume what a Welcome says that has not come yet
  if (datagram.header.kind == protocol::DatagramKind::frame_slice) return on_slice(datagram.body);
  if (datagram.header.kind != protocol::DatagramKind::frame_parity) return;
  if (const auto parity = protocol::decode_parity(datagram.body)) {
    if (requested_.ever_requested(parity->header.frame)) add_rebuilt(recovery_.add_parity(*parity));
  } else {
    ++counters_.invalid_slices;
  }
}

void VisibilityStream::on_slice(std::span<const uint8_t> body) {
  const auto slice = protocol::decode_frame_slice(body);
  if (!slice || !requested_.ever_requested(slice->header.frame)) {
    ++counters_.invalid_slices;
    return;
  }
  add_slice(*slice);
  if (has(protocol::kFeatureParity)) add_rebuilt(recovery_.add_slice(slice->header, body));
}

void VisibilityStream::add_rebuilt(const std::vector<std::vector<uint8_t>>& bodies) {
  for (const auto& body : bodies) {
    const auto slice = protocol::decode_frame_slice(body);
    if (!slice) continue;
    ++counters_.rebuilt_slices;
    add_slice(*slice);
  }
}

void VisibilityStream::plan_report() {
  if (report_planned_ || connection_.state() != Connection::State::open) return;
  report_planned_ = true;
  report_timer_.arm(arrivals_.due_at());
}

void VisibilityStream::report_arrivals() {
  report_planned_ = false;
  const TimePoint now = Clock::now();
  if (arrivals_.due_at() > now) return arrivals_.due_at() == TimePoint::max() ? void() : plan_report();
  protocol::Feedback feedback = arrivals_.take(now);
  feedback.recovered = static_cast<uint32_t>(counters_.rebuilt_slices);
  feedback.incomplete = static_cast<uint32_t>(counters_.incomplete);
  body_.clear();
  protocol::append_feedback(body_, feedback);
  connection_.send(protocol::DatagramKind::feedback, body_);
}

void VisibilityStream::add_slice(const protocol::FrameSlice& slice) {
  const FrameId frame = slice.header.frame;
  if (!has(protocol::kFeatureFeedback)) acks_.received(frame, slice.header.slice);
  RequestedFrames::Request* request = requested_.find(frame);
  if (!request || request->answered || frame < first_of_grid_ || !shape_.is_of(slice.header)) {
    ++counters_.late_slices;
    return;
  }
  switch (assembler_->add(slice)) {
    case SliceOutcome::stored:
    case SliceOutcome::completed: request->last_slice = Clock::now(); break;
    case SliceOutcome::duplicate: ++counters_.duplicate_slices; break;
    case SliceOutcome::late: ++counters_.late_slices; break;
    case SliceOutcome::unreadable:
      ++counters_.unreadable_slices;
      request->last_slice = Clock::now();
      break;
    case SliceOutcome::malformed: ++counters_.invalid_slices; break;
  }
  deliver_finished();
}

void VisibilityStream::deliver_finished() {
  while (auto frame = assembler_->take_finished()) {
    const RequestedFrames::Request* request = requested_.find(frame->frame);
    if (request && !request->answered && request->last_slice) {
      requested_.answered(frame->frame);
      ++(frame->complete() ? counters_.complete : counters_.incomplete);
      counters_.lost_slices += frame->slice_count - frame->slices_received;
      const std::vector<protocol::LightInfo>* lights = lights_.find(frame->moment.lights_version);
      // The camera is copied, as the callback may ask for another one, which moves the requests.
      const Answer answer{request->camera, *frame, lights ? *lights : scene_.lights,
                          *request->last_slice - request->sent, request->index};
      if (events_.answer) events_.answer(answer);
    }
    if (frame->grid == assembler_->grid()) assembler_->recycle(std::move(*frame));
  }
}

void VisibilityStream::upkeep(TimePoint now) {
  expire(now);
  if (connection_.state() != Connection::State::open) return;
  if (requested_.newest().value > 0 && now - last_sent_ >= repeat_interval_) send_newest();
  upkeep_timer_.arm(now + std::min(options_.patience / 2, repeat_interval_));
}

void VisibilityStream::expire(TimePoint now) {
  for (const FrameId frame : requested_.overdue(now, options_.patience)) assembler_->give_up(frame);
  deliver_finished();
  const RequestedFrames::Dropped dropped = requested_.drop_old(now, options_.answer_timeout);
  counters_.superseded += dropped.superseded;
  counters_.unanswered += dropped.unanswered;
}

}  // namespace gnomon::client
