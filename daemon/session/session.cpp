#include "daemon/session/session.h"

#include <utility>

namespace gnomon::daemon {
namespace {

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
      notified_shape_{grant_.width, grant_.height, grant_.samples, grant_.rate_hz},
      seal_(std::move(parts.seal)),
      path_(grant_.has(protocol::kFeaturePaths), parts.random),
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
  if (!opened) return {std::nullopt, fault_of(seal_->rejection()), false, false};
  using protocol::DatagramKind;
  const DatagramKind kind = opened->header.kind;
  const bool newest = opened->header.sequence == seal_->newest_opened();
  const bool streams = kind == DatagramKind::camera_update || kind == DatagramKind::feedback;
  DatagramOutcome received = on_body(kind, opened->body, now);
  if (!is_sound(received)) return received;
  path_.received(from, datagram.size(), newest, streams, now);
  if (streams && newest && path_.current() == from) way_ = Way::datagrams;
  return release(received, now);
}

DatagramOutcome Session::receive(const protocol::Data& data, TimePoint now, Way way) {
  using protocol::DatagramKind;
  const bool streams = data.kind == DatagramKind::camera_update || data.kind == DatagramKind::feedback;
  if (!streams) return {std::nullopt, Fault::datagram_kind};
  const DatagramOutcome received = on_body(data.kind, data.body, now);
  if (!is_sound(received)) return received;
  if (received.fault != Fault::view_out_of_order) way_ = way;  // what is older may have been overtaken
  return release(received, now);
}

// Lets the link decide whether the view is requested now. Of a client that has no address yet one view is rendered
// while the address is validated; the newest of the others is held back, so that who never validates an address is not
// rendered for.
DatagramOutcome Session::release(DatagramOutcome received, TimePoint now) {
  if (!received.view) return received;
  const ViewRequest view = *std::exchange(received.view, std::nullopt);
  if (way_ == Way::datagrams && !path_.current() && std::exchange(asked_early_, true)) {
    views_.withhold(view);
  } else {
    received.view = views_.offer(view, now);
  }
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
    case protocol::DatagramKind::path_response: {
      const auto token = protocol::decode_path_token(body);
      if (!token) return {std::nullopt, Fault::datagram_body};
      last_received_ = now;
      const bool first = !path_.current();
      const auto move = path_.answered(*token);
      // The path to another host is another path; behind another port it most likely is the same (RFC 9000, 9.4).
      if (move && move->other_host) link_.begin_path(now);
      if (move && move->streams) way_ = Way::datagrams;
      if (move) moved_ = !first;
      return {};
    }
    case protocol::DatagramKind::ping: last_received_ = now; return {std::nullopt, std::nullopt, true};
    default: return {std::nullopt, Fault::datagram_kind};
  }
}

DatagramOutcome Session::on_body(const protocol::CameraUpdate& update, TimePoint now) {
  const bool again = newest_ == update.frame;
  if (newest_ && !again && !is_newer(update.frame, *newest_)) return {std::nullopt, Fault::view_out_of_order};
  if (references_) references_->client_has(update.have);
  // The link knows of its lost frames by Feedback. Without it the client's word is taken once for each of its addresses.
  const bool lost = grant_.has(protocol::kFeatureFeedback) ? again && link_.take_lost(update.frame, now)
                                                           : again && std::exchange(moved_, false);
  if (again && !lost) return {};
  moved_ = false;
  newest_ = update.frame;
  if (stored_) stored_.record().newest_frame = update.frame.value;
  // The client's clock is not ours: its deadline counts from the arrival.
  const auto until = std::chrono::microseconds(update.display_deadline_us);
  const TimePoint deadline = until.count() == 0 ? TimePoint::max() : now + until;
  ViewRequest view{id_, update.frame, update.camera, now, deadline};
  view.tenant = grant_.tenant;
  return {view, std::nullopt};
}

void Session::omit_number() {
  if (grant_.has(protocol::kFeatureFeedback) && omitted_.omit_next()) link_.omitted(seal_->skip());
}

LinkReport Session::take_link_report() {
  const LinkCounters before = std::exchange(reported_, link_.counters());
  return {link_.counters() - before, link_.rate(), link_.rtt(), link_.queue_delay()};
}

}  // namespace gnomon::daemon
