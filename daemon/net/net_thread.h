// One thread that owns a data socket and the sessions behind it, their control connections included.
//
// A session stays with the net thread that accepted it: its clients send to that thread's own UDP port, so that no
// datagram ever changes threads and nothing here needs a lock.
#pragma once

#include <asio/executor_work_guard.hpp>
#include <asio/io_context.hpp>
#include <asio/steady_timer.hpp>

#include <atomic>
#include <memory>
#include <string>
#include <thread>
#include <unordered_map>

#include "common/published.h"
#include "daemon/config/config.h"
#include "daemon/config/roster.h"
#include "daemon/metrics/health.h"
#include "daemon/metrics/metrics.h"
#include "daemon/metrics/status.h"
#include "daemon/net/control_stream.h"
#include "daemon/net/data_socket.h"
#include "daemon/net/frame_sender.h"
#include "daemon/net/lobby.h"
#include "daemon/net/tls.h"
#include "daemon/net/wake_list.h"
#include "daemon/render/device_pool.h"
#include "daemon/scenes/scene_host.h"
#include "daemon/session/seats.h"
#include "daemon/session/session_store.h"
#include "daemon/session/session_table.h"

namespace gnomon::daemon {

// What the net threads share with the rest of the daemon. All of it outlives them.
struct NetShared {
  const Config& config;
  const Published<Roster>& roster;
  const std::string& tracer;  // its name, for clients
  const SceneCatalog& catalog;
  const Health& health;
  const PublishedTls& tls;
  SceneHost& scenes;
  Seats& seats;
  SessionStore& store;
  DevicePool& devices;
  Metrics& metrics;
};

class NetThread {
 public:
  static Result<std::unique_ptr<NetThread>> open(const NetShared& shared, uint32_t index);
  ~NetThread();  // closes whatever is open

  asio::io_context& io() { return io_; }
  uint16_t data_port() const { return data_->port(); }
  void run();  // starts the thread

  // Any thread.
  void adopt(asio::ip::tcp::socket socket);  // its executor is io()'s
  void deliver(EncodedFrame frame);
  void tell(const SessionDegraded& session);
  bool kick(SessionId id, const std::string& why);  // false: it is not here. Blocking; not on this thread
  void announce_drain(std::chrono::milliseconds deadline);
  void announce_lights(const LightsNews& news);  // to the sessions of that scene
  void close_closed_tenants();                   // sessions of tenants that the roster has no more
  // Ends the thread; returns when it has ended. Sessions are told Bye, or left for whoever comes after us to resume.
  void stop(bool for_good = true);
  std::shared_ptr<const std::vector<SessionStatus>> sessions() const { return published_.get(); }

 private:
  NetThread(const NetShared& shared, uint32_t index);

  void receive(std::span<const uint8_t> datagram, const asio::ip::udp::endpoint& from);
  void send(EncodedFrame& frame);
  void ask(const Session& session, const ViewRequest& view);
  bool has_way(const Session& session) const;
  void serve(Session& session);
  void finish(Session& session, const Session::Ended& ended, TimePoint now);
  void arm_wakes();
  void wake();

  using OnVisitorMessage = std::function<void(const std::shared_ptr<ControlStream>&, Result<protocol::Message>)>;
  void welcome_visitor(asio::ip::tcp::socket socket);
  void watch_visitor(const std::shared_ptr<ControlStream>& stream, OnVisitorMessage on_message);
  void hear_visitor(const std::shared_ptr<ControlStream>& stream, Result<protocol::Message> message);
  // Who has been accepted and holds a seat while it waits for the rest. Shared with those whose answer it waits for.
  struct Applicant {
    std::weak_ptr<ControlStream> stream;  // should it end, nobody waits
    SessionGrant grant;
    KeptSession kept;  // of the session that it resumes; empty: it opens one
    Seat seat;
    std::shared_ptr<const void> scene_use = {};
  };
  using ApplicantPtr = std::shared_ptr<Applicant>;

  void admit(const std::shared_ptr<ControlStream>& stream, const protocol::Hello& hello);
  void resume(const std::shared_ptr<ControlStream>& stream, const protocol::Resume& asked);
  void resume(const std::shared_ptr<ControlStream>& stream, KeptSession kept);
  void hold(const std::shared_ptr<ControlStream>& stream);
  std::shared_ptr<ControlStream> held(const std::weak_ptr<ControlStream>& stream) const;
  void seat(const std::shared_ptr<ControlStream>& stream, const SessionGrant& grant, KeptSession kept);
  void open_with(const ApplicantPtr& applicant, const Result<SceneForUse>& scene);
  bool book(const std::shared_ptr<ControlStream>& stream, Applicant& applicant);
  void ask_room(const ApplicantPtr& applicant, const scenes::LoadedScene& scene);
  Result<KeptSession> keep_new(ControlStream& stream, const SessionGrant& grant, const scenes::LoadedScene& scene,
                               SessionId id, std::unique_ptr<protocol::Seal>& seal);
  void open_session(const std::shared_ptr<ControlStream>& stream, Applicant& applicant,
                    const scenes::LoadedScene& scene);
  void greet(ControlStream& stream, const Session& session, const scenes::LoadedScene& scene);
  void refuse(const std::shared_ptr<ControlStream>& stream, const protocol::Refused& refused);
  void refuse(const std::shared_ptr<ControlStream>& stream, const protocol::Refused& refused, Fault fault);
  void hear_client(SessionId id, Result<protocol::Message> message);
  void hear_data(SessionId id, const protocol::Data& data);
  void lose_control(SessionId id, const std::string& why);
  void close_session(SessionId id, const std::string& why);
  void leave_session(SessionId id, const std::string& why);
  std::shared_ptr<ControlStream> drop_session(SessionId id, const std::string& why);
  ControlStream* stream_of(SessionId id) const;  // null: it has none at the moment
  void show_out(const std::shared_ptr<ControlStream>& stream);

  void stop_when_all_left(TimePoint deadline);
  void tick();
  void report_stats();

  const NetShared shared_;
  const uint32_t index_;
  asio::io_context io_{1};
  asio::executor_work_guard<asio::io_context::executor_type> work_{io_.get_executor()};
  asio::steady_timer timer_{io_};
  std::unique_ptr<DataSocket> data_;
  FrameSender sender_;
  WakeList wakes_;
  asio::steady_timer wake_timer_{io_};
  TimePoint armed_ = TimePoint::max();  // what wake_timer_ waits for
  Lobby lobby_;
  SessionTable sessions_;
  std::unordered_map<SessionId, std::shared_ptr<ControlStream>> streams_;
  TimePoint next_stats_{};
  std::atomic<uint32_t> frames_waiting_{0};
  Published<std::vector<SessionStatus>> published_;
  std::thread thread_;
};

}  // namespace gnomon::daemon
