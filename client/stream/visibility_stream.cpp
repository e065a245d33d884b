#include "client/stream/visibility_stream.h"

#include <algorithm>
#include <utility>

namespace gnomon::client {
namespace {

constexpr Nanoseconds kRepeatInterval = std::chrono::milliseconds(250);
constexpr size_t kLightVersions = 16;  // kept for frames that are still on their way

StreamOptions with_features(StreamOptions options) {
  using namespace protocol;
  options.connect.hello.features |= kFeatureMoments | kFeatureFeedback | kFeatureParity | kFeatureSizes;
  if (options.keep_references) options.connect.hello.features |= kFeatureReferences;
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
  wrong_frames += other.wrong_frames;
  return *this;
}

VisibilityStream::VisibilityStream(Loop& loop, StreamOptions options, Events events)
    : options_(with_features(std::move(options))),
      events_(std::move(events)),
      upkeep_timer_(loop, [this] { upkeep(Clock::now()); }),
      report_timer_(loop, [this] { report_arrivals(); }),
      connection_(loop, options_.connect,
                  {.opened = [this] { start(); },
                   .resumed = [this] { go_on(); },
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
  take_up(welcome);
  const auto silence = std::chrono::milliseconds(welcome.silence_timeout_ms);
  repeat_interval_ = silence.count() > 0 ? std::min<Nanoseconds>(kRepeatInterval, silence / 4) : kRepeatInterval;
  upkeep(Clock::now());
  if (events_.opened) events_.opened();
}

void VisibilityStream::take_up(const protocol::Welcome& welcome) {
  scene_ = welcome.scene;
  lights_.clear();
  keep_lights(welcome.lights_version, scene_.lights);
  restart_with({welcome.width, welcome.height, static_cast<uint32_t>(scene_.lights.size())});
}

// A camera that was under way is asked for anew: its answer may be lost, or begun and never to be ended.
void VisibilityStream::go_on() {
  ++counters_.resumed;
  assembler_.reset();
  recovery_ = {};
  take_up(connection_.welcome());
  first_of_use_ = FrameId{newest_asked_.value + 1};
  if (in_flight() == 0) return;
  const protocol::CameraView camera = newest_.camera;
  ask(camera, std::chrono::microseconds(newest_.display_deadline_us));
  if (events_.asked_again) events_.asked_again();
}

// Frames asked for before this may have another shape. Where slices do not say which, they are of no use any more: they
// say their size to whom wants it, and nothing of lights.
void VisibilityStream::restart_with(TileGrid grid) {
  if (assembler_ && assembler_->grid() == grid) return;
  const bool tell_apart = has(protocol::kFeatureSizes) && assembler_ && assembler_->grid().lights == grid.lights;
  assembler_.emplace(grid);
  if (connection_.welcome().features & protocol::kFeatureReferences) assembler_->keep_references();
  if (!tell_apart) first_of_use_ = FrameId{newest_asked_.value + 1};
}

void VisibilityStream::on_message(const protocol::Message& message) {
  TileGrid changed = grid();
  if (const auto* degraded = std::get_if<protocol::Degraded>(&message)) {
    const auto& welcome = connection_.welcome();
    if (degraded->width > 0 && degraded->width <= welcome.width) changed.width = degraded->width;
    if (degraded->height > 0 && degraded->height <= welcome.height) changed.height = degraded->height;
  } else if (const auto* scene = std::get_if<protocol::SceneChanged>(&message)) {
    scene_ = scene->scene;
    lights_.clear();
  } else if (const auto* lights = std::get_if<protocol::LightsChanged>(&message)) {
    scene_.lights = lights->lights;
    keep_lights(lights->version, scene_.lights);
  }
  changed.lights = static_cast<uint32_t>(std::min<size_t>(scene_.lights.size(), protocol::kMaxLights));
  restart_with(changed);
  if (events_.message) events_.message(message);
}

FrameId VisibilityStream::ask(const protocol::CameraView& camera, Nanoseconds display_deadline) {
  const TimePoint now = Clock::now();
  newest_asked_ = FrameId{newest_asked_.value + 1};
  newest_.frame = newest_asked_;
  newest_.camera = camera;
  newest_.client_time_us = static_cast<uint64_t>(to_microseconds(now.time_since_epoch()));
  newest_.display_deadline_us = static_cast<uint32_t>(to_microseconds(display_deadline));
  asked_.push_back({camera, now, {}, false});
  ++counters_.asked;
  send_newest();
  return newest_asked_;
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
  if (connection_.resuming()) return;  // it may be of the session as it is after the Welcome that is still to come
  if (datagram.header.kind == protocol::DatagramKind::frame_slice) return on_slice(datagram.body);
  if (datagram.header.kind != protocol::DatagramKind::frame_parity) return;
  if (const auto parity = protocol::decode_parity(datagram.body)) {
    if (may_be_asked_for(parity->header.frame)) add_rebuilt(recovery_.add_parity(*parity));
  } else {
    ++counters_.wrong_frames;
  }
}

void VisibilityStream::on_slice(std::span<const uint8_t> body) {
  const auto slice = protocol::decode_frame_slice(body);
  if (!slice || !may_be_asked_for(slice->header.frame)) {
    ++counters_.wrong_frames;
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

bool VisibilityStream::may_be_asked_for(FrameId frame) const { return frame.value != 0 && frame <= newest_asked_; }

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
  Asked* asked = find(frame);
  if (!asked || asked->answered || frame < first_of_use_ || !is_of_grid(slice.header)) {
    ++counters_.late_slices;
    return;
  }
  switch (assembler_->add(slice)) {
    case SliceOutcome::stored:
    case SliceOutcome::completed: asked->last_slice = Clock::now(); break;
    case SliceOutcome::duplicate: ++counters_.duplicate_slices; break;
    case SliceOutcome::late: ++counters_.late_slices; break;
    case SliceOutcome::unreadable:
      ++counters_.unreadable_slices;
      asked->last_slice = Clock::now();
      break;
    case SliceOutcome::malformed: ++counters_.wrong_frames; break;
  }
  deliver_finished();
}

// Slices of a new size may overtake the news of it, and those of the former one come after it.
bool VisibilityStream::is_of_grid(const protocol::SliceHeader& header) const {
  if (!has(protocol::kFeatureSizes)) return true;
  const auto& granted = connection_.welcome();
  const bool says = (header.flags & protocol::kSliceHasSize) != 0;
  return grid().width == (says ? header.width : granted.width) &&
         grid().height == (says ? header.height : granted.height);
}

void VisibilityStream::deliver_finished() {
  while (auto frame = assembler_->take_finished()) {
    Asked* asked = find(frame->frame);
    if (asked && !asked->answered && asked->last_slice) {
      asked->answered = true;
      newest_answered_ = std::max(newest_answered_, frame->frame);
      ++(frame->complete() ? counters_.complete : counters_.incomplete);
      counters_.lost_slices += frame->slice_count - frame->slices_received;
      // A copy: the call back may ask for another camera, which moves the records.
      const Answer answer{asked->camera, *frame, lights_of(frame->moment.lights_version),
                          *asked->last_slice - asked->sent};
      if (events_.answer) events_.answer(answer);
    }
    if (frame->grid == assembler_->grid()) assembler_->recycle(std::move(*frame));
  }
}

void VisibilityStream::upkeep(TimePoint now) {
  expire(now);
  if (connection_.state() != Connection::State::open) return;
  if (newest_asked_.value > 0 && now - last_sent_ >= repeat_interval_) send_newest();
  upkeep_timer_.arm(now + std::min(options_.patience / 2, repeat_interval_));
}

void VisibilityStream::expire(TimePoint now) {
  for (size_t i = 0; i < asked_.size(); ++i) {
    const Asked& asked = asked_[i];
    if (asked.answered || !asked.last_slice || now - *asked.last_slice < options_.patience) continue;
    assembler_->give_up(FrameId{newest_asked_.value - static_cast<uint32_t>(asked_.size() - 1 - i)});
  }
  deliver_finished();
  while (!asked_.empty() && (asked_.front().answered || now - asked_.front().sent >= options_.answer_timeout)) {
    const FrameId frame{newest_asked_.value - static_cast<uint32_t>(asked_.size() - 1)};
    if (!asked_.front().answered) {
      ++(frame < newest_answered_ ? counters_.superseded : counters_.unanswered);
    }
    asked_.pop_front();
  }
}

void VisibilityStream::keep_lights(uint32_t version, const std::vector<protocol::LightInfo>& lights) {
  lights_[version] = lights;
  if (lights_.size() > kLightVersions) lights_.erase(lights_.begin());
}

// Slices may overtake the news of their lights.
const std::vector<protocol::LightInfo>& VisibilityStream::lights_of(uint32_t version) const {
  const auto found = lights_.find(version);
  return found == lights_.end() ? scene_.lights : found->second;
}

VisibilityStream::Asked* VisibilityStream::find(FrameId frame) {
  const uint32_t back = newest_asked_.value - frame.value;
  return back < asked_.size() ? &asked_[asked_.size() - 1 - back] : nullptr;
}

}  // namespace gnomon::client
