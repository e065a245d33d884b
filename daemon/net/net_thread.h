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
#include <optional>
#include <string>
#include <thread>

#include "daemon/net/admission.h"
#include "daemon/net/lobby.h"
#include "daemon/net/net_shared.h"
#include "daemon/net/open_sessions.h"
#include "daemon/net/session_control.h"
#include "daemon/net/session_links.h"
#include "daemon/net/session_statistics.h"

namespace gnomon::daemon {

class NetThread {
 public:
  static Result<std::unique_ptr<NetThread>> open(const NetShared& shared, uint32_t index);
  ~NetThread();  // closes whatever is open

  asio::io_context& io() { return io_; }
  uint16_t data_port() const { return links_.data_port(); }
  void run();  // starts the thread

  // Any thread.
  void adopt(asio::ip::tcp::socket socket);  // its executor is io()'s
  void deliver(EncodedFrame frame);
  void notify(const SessionDegraded& session);
  bool kick(SessionId id, const std::string& why);  // false: it is not here. Blocking; not on this thread
  void announce_drain(std::chrono::milliseconds deadline);
  void announce_lights(const LightsNews& news);  // to the sessions of that scene
  void close_closed_tenants();                   // sessions of tenants that the roster has no more
  // Ends the thread; returns when it has ended. Sessions are told Bye, or left for whoever comes after us to resume.
  void stop(bool for_good = true);
  std::shared_ptr<const std::vector<SessionStatus>> sessions() const { return statistics_.latest(); }

 private:
  NetThread(const NetShared& shared, uint32_t index);

  void tick();
  void stop_when_all_left(TimePoint deadline);

  const NetShared shared_;
  const uint32_t index_;
  asio::io_context io_{1};
  asio::executor_work_guard<asio::io_context::executor_type> work_{io_.get_executor()};
  asio::steady_timer timer_{io_};
  Lobby lobby_;
  OpenSessions sessions_;
  SessionLinks links_{shared_, sessions_, io_};
  SessionControl control_{shared_, index_, io_, sessions_, links_, lobby_};
  SessionStatistics statistics_{shared_, sessions_};
  std::optional<Admission> admission_;  // from open() on
  std::atomic<uint32_t> frames_waiting_{0};
  std::thread thread_;
};

}  // namespace gnomon::daemon
