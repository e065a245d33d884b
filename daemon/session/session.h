// One client's use of one scene: what its datagrams mean, where its frames go, what it has cost lately.
#pragma once

#include <asio/ip/udp.hpp>

#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "daemon/frame/frame.h"
#include "daemon/frame/grant.h"
#include "daemon/frame/scene_use.h"
#include "daemon/frame/session_references.h"
#include "daemon/link/link_window.h"
#include "daemon/metrics/faults.h"
#include "daemon/metrics/link_report.h"
#include "daemon/session/handshake.h"
#include "daemon/session/seats.h"
#include "daemon/session/session_store.h"
#include "protocol/seal.h"

namespace gnomon::daemon {

// What a datagram amounts to: a view, or what is wrong with it, or neither (a repeated frame id is no news, unless all
// of its answer was lost; a view that the link has no room for is kept).
struct Received {
  std::optional<ViewRequest> view;
  std::optional<Fault> fault;
  bool ping = false;  // to be answered to where it came from
};

// What a session is made of.
struct SessionParts {
  SessionId id{};
  SessionGrant grant = {};
  std::unique_ptr<protocol::Seal> seal;
  Seat seat;
  KeptSession kept = {};    // the seal goes on from what lies in there; empty if it cannot be resumed
  SceneUse scene_use = {};  // keeps the scene from being unloaded
};

// The net thread's that owns it.
class Session {
 public:
  Session(SessionParts parts, TimePoint now);

  SessionId id() const { return id_; }
  const SessionGrant& grant() const { return grant_; }
  protocol::Seal& seal() { return *seal_; }
  LinkSender& link() { return link_; }

  // The client's last words came over its control connection: what is for it goes there.
  bool by_control() const { return by_control_; }

  // Where the last valid datagram came from; nothing is sent anywhere else.
  const std::optional<asio::ip::udp::endpoint>& address() const { return address_; }

  // What would have come in a datagram.
  Received receive(const protocol::Data& data, TimePoint now);

  Received receive(std::span<const uint8_t> datagram, const asio::ip::udp::endpoint& from, TimePoint now);

  // The newest view, if it was kept and the link has room for it now. When to ask again; max: it was not kept.
  std::optional<ViewRequest> take_kept(TimePoint now);
  TimePoint kept_until(TimePoint now) const;
  LinkWindow take_link_window() { return std::exchange(window_, {}); }  // views since the last call

  // A frame on its way through the link; the frames whose sending is over come back, in their order.
  void sending(const FrameMeta& meta, size_t bytes) { under_way_.push_back({meta, bytes}); }
  struct Ended {
    FrameMeta meta;
    size_t bytes = 0;
    bool whole = false;
  };
  std::optional<Ended> take_ended();

  // What the client keeps of frames; null if it keeps none.
  const SessionReferencesPtr& references() const { return references_; }

  TimePoint last_heard() const { return last_heard_; }

  // Without its control connection it goes on until then, if it may be resumed.
  bool resumable() const { return static_cast<bool>(for_resuming_); }
  void control_lost(TimePoint until) { resumed_until_ = until; }
  TimePoint resumed_until() const { return resumed_until_; }
  // How often it was resumed in all: news of an earlier life is void.
  uint32_t life() const { return for_resuming_ ? for_resuming_.record().life : 0; }

  // The size of frames that the client has been told to expect.
  void told_of(uint16_t width, uint16_t height) { told_width_ = width, told_height_ = height; }
  bool expects(const TileGrid& grid) const { return grid.width == told_width_ && grid.height == told_height_; }
  void forget();  // nobody resumes it any more, and nothing is sealed any more

  void frame_sent(const FrameMeta& meta, TimePoint sent);

  LinkReport take_link_report();

  // Totals of the session, means since the last call (those of an interval without frames are 0).
  protocol::Stats take_stats();

 private:
  struct Sums {
    uint32_t frames = 0;
    Nanoseconds queue{}, gpu{}, total{};
  };

  struct UnderWay {
    FrameMeta meta;
    size_t bytes = 0;
  };

  Received hear(protocol::DatagramKind kind, std::span<const uint8_t> body, TimePoint now);
  Received hear(const protocol::CameraUpdate& update, TimePoint now);
  ViewRequest released(ViewRequest view, TimePoint now);

  SessionId id_;
  SessionGrant grant_;
  SceneUse scene_use_;
  KeptSession for_resuming_;  // given up after the seat, which whoever resumes it takes
  Seat seat_;
  uint32_t told_width_, told_height_;
  TimePoint resumed_until_ = TimePoint::max();
  std::unique_ptr<protocol::Seal> seal_;
  std::optional<asio::ip::udp::endpoint> address_;
  bool by_control_ = false;
  std::optional<FrameId> newest_;
  SessionReferencesPtr references_;
  TimePoint last_heard_;
  LinkSender link_;
  std::optional<ViewRequest> kept_;
  std::deque<UnderWay> under_way_;
  uint64_t frames_ = 0;
  uint64_t coalesced_ = 0;
  Sums recent_;
  LinkCounters reported_;
  LinkWindow window_;
};

}  // namespace gnomon::daemon
