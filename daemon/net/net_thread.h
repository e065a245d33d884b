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
#include "daemon/net/net_shared.h"
#include "daemon/net/open_sessions.h"
#include "daemon/net/pending_connections.h"
#include "daemon/net/session_control.h"
#include "daemon/net/session_links.h"
#include "daemon/net/session_statistics.h"

namespace gnomon::daemon {

class NetThread {
 public:
  // Error if the data socket cannot be opened. `index`: among the net threads.
  static Result<std::unique_ptr<NetThread>> open(const NetShared& shared, uint32_t index);
  ~NetThread();  // stop()

  asio::io_context& io() { return io_; }
  uint16_t data_port() const { return links_.data_port(); }
  void run();  // starts the thread

  // Any thread; the blocking calls any thread but this one.
  // The socket's executor is that of io(). `client`: who is at its other end, or at that of a proxy.
  void adopt(asio::ip::tcp::socket socket, const asio::ip::address& client);
  void deliver(EncodedFrame frame);  // dropped and counted if too many frames wait
  void notify(const SessionDegraded& session);
  bool kick(SessionId id, const Kick& kick);  // false if the session is not here. Blocks
  void announce_drain(std::chrono::milliseconds deadline);
  void ask_to_move(bool move);                       // the clients of a fleet: to another node of it
  void announce_lights(const LightsUpdate& update);  // to the sessions of its scene
  void close_unwelcome();                            // at once the sessions that may not go on after a reload
  // Ends the thread; blocks until it has ended. `for_good`: every session is closed; otherwise those that can be
  // resumed are left for the next process.
  void stop(bool for_good = true);
  std::shared_ptr<const std::vector<SessionStatus>> sessions() const { return statistics_.latest(); }

 private:
  void serve();  // the thread
  NetThread(const NetShared& shared, uint32_t index);

  void tick();
  void review(TimePoint now);
  void stop_when_all_left(TimePoint deadline);

  const NetShared shared_;
  const uint32_t index_;
  asio::io_context io_{1};
  asio::executor_work_guard<asio::io_context::executor_type> work_{io_.get_executor()};
  asio::steady_timer timer_{io_};
  PendingConnections pending_;
  OpenSessions sessions_;
  SessionLinks links_{shared_, sessions_, io_};
  SessionControl control_{shared_, index_, io_, sessions_, links_, pending_};
  SessionStatistics statistics_{shared_, sessions_};
  std::optional<Admission> admission_;  // set by open()
  TimePoint next_review_{};             // of who may not go on
  std::atomic<uint32_t> frames_waiting_{0};
  std::thread thread_;
};

}  // namespace gnomon::daemon
