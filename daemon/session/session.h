// One client's use of one scene: it interprets the client's datagrams, knows where its frames go, and sums what they
// took.
#pragma once

#include <asio/ip/udp.hpp>

#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "daemon/frame/frame.h"
#include "daemon/frame/grant.h"
#include "daemon/frame/scene_use.h"
#include "daemon/frame/session_references.h"
#include "daemon/link/omitted_numbers.h"
#include "daemon/metrics/faults.h"
#include "daemon/metrics/link_report.h"
#include "daemon/security/random_bytes.h"
#include "daemon/session/frames_under_way.h"
#include "daemon/session/handshake.h"
#include "daemon/session/path_validation.h"
#include "daemon/session/session_limits.h"
#include "daemon/session/session_store.h"
#include "daemon/session/session_totals.h"
#include "daemon/session/view_buffer.h"
#include "protocol/seal.h"

namespace gnomon::daemon {

// The result of a datagram: a view, or a fault, or neither (a repeated frame id is ignored, unless all of its answer
// was lost; a view that the link has no room for is kept until it has).
struct DatagramOutcome {
  std::optional<ViewRequest> view;
  std::optional<Fault> fault;
  bool ping = false;   // the datagram has to be answered to the address that it came from
  bool opened = true;  // false if the datagram is not authentic

  // The client has said what cannot be true: its session is to be closed.
  bool ends_session() const { return fault == Fault::feedback_invented; }
};

// Which way a client's views come, and its frames go.
enum class Way : uint8_t { datagrams, control, web_transport };

// What a session is made of.
struct SessionParts {
  SessionId id{};
  SessionGrant grant = {};
  std::unique_ptr<protocol::Seal> seal;
  SessionPermit permit;
  StoredSession stored = {};  // record from which the seal continues; empty if the session cannot be resumed
  SceneUse scene_use = {};    // keeps the scene from being unloaded
  std::function<uint64_t()> random = random_number;  // unpredictable
};

// The size and the samples of frames that the client has been notified of, its rate, and how many lights are not traced.
struct NotifiedShape {
  uint32_t width = 0, height = 0;
  SampleCounts samples = {};
  double rate_hz = 0;
  uint32_t untraced_lights = 0;
  bool is_of(const FrameSpec& spec) const {
    return spec.grid.width == width && spec.grid.height == height && spec.samples == samples;
  }
};

// Belongs to the net thread that owns it.
class Session {
 public:
  Session(SessionParts parts, TimePoint now);

  SessionId id() const { return id_; }
  const SessionGrant& grant() const { return grant_; }
  protocol::Seal& seal() { return *seal_; }
  LinkSender& link() { return link_; }
  // Leaves out a sequence number now and then, so that invented Feedback is found out. Called before a number is taken
  // for a datagram.
  void omit_number();

  // The way that the client's last view or feedback came; frames are sent the same. Set to another one where that is no
  // more.
  Way& way() { return way_; }

  // Where datagrams go. After each datagram that was received, challenges may be due.
  PathValidation& path() { return path_; }

  // Receives what replaces a datagram: a message, or a datagram of WebTransport.
  DatagramOutcome receive(const protocol::Data& data, TimePoint now, Way way = Way::control);

  DatagramOutcome receive(std::span<const uint8_t> datagram, const asio::ip::udp::endpoint& from, TimePoint now);

  ViewBuffer& views() { return views_; }
  SessionTotals& totals() { return totals_; }
  FramesUnderWay& under_way() { return under_way_; }

  // What the client keeps of earlier frames; nullptr if it keeps none.
  const SessionReferencesPtr& references() const { return references_; }

  TimePoint last_received() const { return last_received_; }

  bool resumable() const { return static_cast<bool>(stored_); }
  // How long the session continues without its control connection; max while it has one.
  TimePoint& resumed_until() { return resumed_until_; }
  const SessionPermit& permit() const { return permit_; }
  // Counts how often the session was resumed. Notifications carrying an older generation are ignored.
  uint32_t generation() const { return stored_ ? stored_.record().generation : 0; }

  NotifiedShape& notified_shape() { return notified_shape_; }
  void forget();  // the session cannot be resumed any more, and nothing is sealed any more

  LinkReport take_link_report();

 private:
  DatagramOutcome on_body(protocol::DatagramKind kind, std::span<const uint8_t> body, TimePoint now);
  DatagramOutcome on_body(const protocol::CameraUpdate& update, TimePoint now);
  DatagramOutcome release(DatagramOutcome received, TimePoint now);

  SessionId id_;
  SessionGrant grant_;
  SceneUse scene_use_;
  StoredSession stored_;  // destroyed after the permit, which the connection that resumes the session takes
  SessionPermit permit_;
  NotifiedShape notified_shape_;
  TimePoint resumed_until_ = TimePoint::max();
  std::unique_ptr<protocol::Seal> seal_;
  PathValidation path_;
  Way way_ = Way::datagrams;
  bool asked_early_ = false;  // a view was rendered before the client had an address
  bool moved_ =
      false;  // the path has moved and no view came since: the last frame may have gone to the former address
  std::optional<FrameId> newest_;
  SessionReferencesPtr references_;
  TimePoint last_received_;
  LinkSender link_;
  OmittedNumbers omitted_;
  ViewBuffer views_{link_};
  SessionTotals totals_;
  FramesUnderWay under_way_{link_};
  LinkCounters reported_;
};

}  // namespace gnomon::daemon
