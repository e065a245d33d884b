#include "daemon/session/session.h"

#include <utility>

namespace gnomon::daemon {
namespace {

// Frame ids count up and may wrap: of two, the newer is less than half the circle ahead.
bool is_newer(FrameId a, FrameId b) { return static_cast<int32_t>(a.value - b.value) > 0; }

// Whether the datagram shows where the client is; one with an old view does so as well as one with a new view.
bool is_sound(const DatagramOutcome& received) {
  return received.fault != Fault::datagram_body && received.fault != Fault::datagram_kind;
}

std::optional<Fault> fault_of(FeedbackVerdict verdict) {
  switch (verdict) {
    case FeedbackVerdict::taken: break;
    case FeedbackVerdict::too_many: return Fault::feedback_too_often;
    case FeedbackVerdict::invented: return Fault::feedback_invented;
  }
  return std::nullopt;
}

Fault fault_of(protocol::Rejection why) {
  switch (why) {
    case protocol::Rejection::header: return Fault::datagram_header;
    case protocol::Rejection::session: return Fault::datagram_session;
    case protocol::Rejection::replayed: return Fault::datagram_replayed;
    case protocol::Rejection::forged: break;
  }
  return Fault::datagram_forged;
}

}  // namespace

Session::Session(SessionParts parts, TimePoint now)
    : id_(parts.id),
      grant_(std::move(parts.grant)),
      scene_use_(std::move(parts.scene_use)),
      stored_(std::move(parts.stored)),
      permit_(std::move(parts.permit)),
      notified_size_{grant_.width, grant_.height},
      seal_(std::move(parts.seal)),
      last_received_(now),
      link_(grant_.features, generation() > 0 ? std::optional(seal_->taken()) : std::nullopt),
      omitted_(std::move(parts.random)) {
  if (grant_.has(protocol::kFeatureReferences)) references_ = std::make_shared<SessionReferences>();
  // Cameras from before the resumption are not answered again: slices of two answers to one camera must not be mixed.
  if (stored_ && stored_.record().newest_frame != 0) newest_ = FrameId{stored_.record().newest_frame};
}

void Session::forget() {
  seal_.reset();
  stored_.forget();
}

DatagramOutcome Session::receive(std::span<const uint8_t> datagram, const asio::ip::udp::endpoint& from,
                                 TimePoint now) {
  const auto opened = seal_->open(datagram);
  if (!opened) return {std::nullopt, fault_of(seal_->rejection())};
  // A ping is answered wherever it comes from, and does not change the session's address: the client is trying a path.
  if (opened->header.kind == protocol::DatagramKind::ping) {
    last_received_ = now;
    return {std::nullopt, std::nullopt, true};
  }
  const DatagramOutcome received = on_body(opened->header.kind, opened->body, now);
  if (is_sound(received)) {
    address_ = from;
    by_control_ = false;
  }
  return received;
}

DatagramOutcome Session::receive(const protocol::Data& data, TimePoint now) {
  const DatagramOutcome received = on_body(data.kind, data.body, now);
  if (is_sound(received)) by_control_ = true;
  return received;
}

DatagramOutcome Session::on_body(protocol::DatagramKind kind, std::span<const uint8_t> body, TimePoint now) {
  switch (kind) {
    case protocol::DatagramKind::camera_update: {
      const auto update = protocol::decode_camera_update(body);
      if (!update) return {std::nullopt, Fault::datagram_body};
      last_received_ = now;
      return on_body(*update, now);
    }
    case protocol::DatagramKind::feedback: {
      if (!grant_.has(protocol::kFeatureFeedback)) return {std::nullopt, Fault::datagram_kind};
      const auto feedback = protocol::decode_feedback(body);
      if (!feedback) return {std::nullopt, Fault::datagram_body};
      last_received_ = now;
      return {std::nullopt, fault_of(link_.on_feedback(*feedback, now))};
    }
    default: return {std::nullopt, Fault::datagram_kind};
  }
}

DatagramOutcome Session::on_body(const protocol::CameraUpdate& update, TimePoint now) {
  const bool again = newest_ == update.frame;
  if (newest_ && !again && !is_newer(update.frame, *newest_)) return {std::nullopt, Fault::view_out_of_order};
  if (references_) references_->client_has(update.have);
  if (again && !link_.take_lost(update.frame, now)) return {};
  newest_ = update.frame;
  if (stored_) stored_.record().newest_frame = update.frame.value;
  // The client's clock is not ours: its deadline counts from the arrival.
  const auto until = std::chrono::microseconds(update.display_deadline_us);
  const TimePoint deadline = until.count() == 0 ? TimePoint::max() : now + until;
  ViewRequest view{id_, update.frame, update.camera, now, deadline};
  view.tenant = grant_.tenant;
  return {views_.offer(view, now), std::nullopt};
}

void Session::omit_number() {
  if (grant_.has(protocol::kFeatureFeedback) && omitted_.omit_next()) link_.omitted(seal_->skip());
}

LinkReport Session::take_link_report() {
  const LinkCounters before = std::exchange(reported_, link_.counters());
  return {link_.counters() - before, link_.rate(), link_.rtt(), link_.queue_delay()};
}

}  // namespace gnomon::daemon
