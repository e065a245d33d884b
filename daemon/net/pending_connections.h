// Connections without a session: those that have not been admitted yet, and those that are being closed gracefully.
//
// Their number and their time are bounded. When there are too many, the oldest is pushed out: a client that opens
// connections and says nothing pushes out its own, while an honest client is admitted within a round trip.
#pragma once

#include <algorithm>
#include <list>
#include <memory>
#include <vector>

#include "common/clock.h"
#include "daemon/net/control_stream.h"

namespace gnomon::daemon {

// `leaving`: it is being closed gracefully.
struct PendingConnection {
  std::shared_ptr<ControlStream> stream;
  TimePoint deadline;
  bool leaving = false;
};

// The net thread's.
class PendingConnections {
 public:
  explicit PendingConnections(size_t max) : max_(max) {}

  // Returns those that were pushed out for it, which the caller closes.
  std::vector<PendingConnection> add(PendingConnection connection) {
    connections_.push_back(std::move(connection));
    std::vector<PendingConnection> out;
    while (connections_.size() > max_) {
      out.push_back(std::move(connections_.front()));
      connections_.pop_front();
    }
    return out;
  }

  // Lets the client read our last words and close the connection, for a second at most.
  void close_gracefully(const std::shared_ptr<ControlStream>& stream, TimePoint now) {
    stream->finish();
    for (const PendingConnection& pushed_out : add({stream, now + kFarewell, true})) pushed_out.stream->close();
  }

  // Returns false if it was not here.
  bool remove(const ControlStream* stream) {
    return std::erase_if(connections_, [&](const PendingConnection& c) { return c.stream.get() == stream; }) > 0;
  }

  // Whether it is here and not being closed.
  bool is_waiting(const ControlStream* stream) const {
    return std::any_of(connections_.begin(), connections_.end(),
                       [&](const PendingConnection& c) { return c.stream.get() == stream && !c.leaving; });
  }

  // Takes out those whose deadline has passed and those that are closed.
  std::vector<PendingConnection> expire(TimePoint now) {
    std::vector<PendingConnection> out;
    std::erase_if(connections_, [&](PendingConnection& c) {
      if (c.deadline > now && c.stream->is_open()) return false;
      out.push_back(std::move(c));
      return true;
    });
    return out;
  }

  size_t size() const { return connections_.size(); }

 private:
  static constexpr auto kFarewell = std::chrono::seconds(1);

  size_t max_;
  std::list<PendingConnection> connections_;  // oldest first
};

}  // namespace gnomon::daemon
