// Connections without a session: those that have not been admitted yet, and those that are being closed gracefully.
//
// Their number and their time are bounded. When there are too many, the oldest is pushed out: a client that opens many
// idle connections pushes out its own, while an honest client is admitted within a round trip.
#pragma once

#include <algorithm>
#include <list>
#include <memory>
#include <vector>

#include "common/clock.h"
#include "daemon/net/control_stream.h"

namespace gnomon::daemon {

// `leaving`: the connection is being closed gracefully.
struct PendingConnection {
  std::shared_ptr<ControlStream> stream;
  TimePoint deadline;
  bool leaving = false;
};

// Belongs to the net thread.
class PendingConnections {
 public:
  explicit PendingConnections(size_t max) : max_(max) {}

  // Returns the connections that were pushed out for it; the caller closes them.
  std::vector<PendingConnection> add(PendingConnection connection) {
    connections_.push_back(std::move(connection));
    std::vector<PendingConnection> out;
    while (connections_.size() > max_) {
      out.push_back(std::move(connections_.front()));
      connections_.pop_front();
    }
    return out;
  }

  // Lets the client read the last messages and close the connection, for at most a second.
  void close_gracefully(const std::shared_ptr<ControlStream>& stream, TimePoint now) {
    stream->finish();
    for (const PendingConnection& pushed_out : add({stream, now + kFarewell, true})) pushed_out.stream->close();
  }

  // Returns false if the connection was not pending.
  bool remove(const ControlStream* stream) {
    return std::erase_if(connections_, [&](const PendingConnection& c) { return c.stream.get() == stream; }) > 0;
  }

  // Whether the connection is pending and not being closed.
  bool is_waiting(const ControlStream* stream) const {
    return std::any_of(connections_.begin(), connections_.end(),
                       [&](const PendingConnection& c) { return c.stream.get() == stream && !c.leaving; });
  }

  // Removes and returns the connections whose deadline has passed and those that are closed.
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
