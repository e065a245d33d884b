// Connections without a session, in two classes.
//
// Strangers have not shown who they are, or are being closed gracefully. Their number and their time are bounded; when
// there are too many, one of the network that has most of them is pushed out (HalfOpenPlaces). Applicants have: a Hello
// that was accepted or a session that they may resume. They wait for a scene or for room, as long as it takes, and no
// stranger pushes them out; their number is bounded by the permits and records that they hold.
#pragma once

#include <map>
#include <memory>
#include <vector>

#include "common/clock.h"
#include "daemon/net/control_stream.h"
#include "daemon/net/half_open_places.h"

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
  explicit PendingConnections(size_t max_strangers) : places_(max_strangers) {}

  // Adds a stranger that has until `deadline`. Returns who was pushed out for it, whom the caller closes: a connection
  // without a stream if nobody was.
  PendingConnection add(const std::shared_ptr<ControlStream>& stream, TimePoint deadline) {
    return add({stream, deadline});
  }

  // The stranger has shown who it is: from now on it is an applicant. Precondition: the connection is waiting.
  void mark_authenticated(const ControlStream* stream) {
    places_.give_back(stream);
    connections_.at(stream).deadline = TimePoint::max();
  }

  // Until when the connection may stay, if it is waiting as a stranger.
  void set_deadline(const ControlStream* stream, TimePoint deadline) {
    const auto found = connections_.find(stream);
    if (found != connections_.end() && !found->second.leaving) found->second.deadline = deadline;
  }

  // Lets the client read the last messages and close the connection, for at most a second. Precondition: the connection
  // is not pending.
  void close_gracefully(const std::shared_ptr<ControlStream>& stream, TimePoint now) {
    stream->finish();
    const PendingConnection pushed_out = add({stream, now + kFarewell, true});
    if (pushed_out.stream) pushed_out.stream->close();
  }

  // Returns false if the connection was not pending.
  bool remove(const ControlStream* stream) {
    places_.give_back(stream);
    return connections_.erase(stream) > 0;
  }

  // Whether the connection is pending and not being closed.
  bool is_waiting(const ControlStream* stream) const {
    const auto found = connections_.find(stream);
    return found != connections_.end() && !found->second.leaving;
  }

  // Removes and returns the connections whose deadline has passed and those that are closed.
  std::vector<PendingConnection> expire(TimePoint now) {
    std::vector<PendingConnection> out;
    for (const auto& [stream, connection] : connections_) {
      if (connection.deadline <= now || !stream->is_open()) out.push_back(connection);
    }
    for (const PendingConnection& connection : out) remove(connection.stream.get());
    return out;
  }

  size_t size() const { return connections_.size(); }
  size_t strangers() const { return places_.taken(); }

 private:
  static constexpr auto kFarewell = std::chrono::seconds(1);

  PendingConnection add(PendingConnection connection) {
    const ControlStream* const stream = connection.stream.get();
    const auto pushed_out = places_.take(stream, network_of(stream->peer()));
    connections_.emplace(stream, std::move(connection));
    if (!pushed_out) return {};
    const auto out = connections_.extract(*pushed_out);
    return out.mapped();
  }

  HalfOpenPlaces<const ControlStream*> places_;  // of strangers
  std::map<const ControlStream*, PendingConnection> connections_;
};

}  // namespace gnomon::daemon
