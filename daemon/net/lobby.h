// Connections without a session: those that have not been admitted yet, and those that are being shown out.
//
// Bounded in number and in time. When it is full the oldest has to go: somebody who opens connections and says
// nothing only pushes out his own, while an honest client is through in a round trip.
#pragma once

#include <algorithm>
#include <list>
#include <memory>
#include <vector>

#include "common/clock.h"
#include "daemon/net/control_stream.h"

namespace gnomon::daemon {

struct Visitor {
  std::shared_ptr<ControlStream> stream;
  TimePoint deadline;
  bool leaving = false;
};

class Lobby {
 public:
  explicit Lobby(size_t max) : max_(max) {}

  // Gives the one who had to go for it, if any.
  std::vector<Visitor> enter(Visitor visitor) {
    visitors_.push_back(std::move(visitor));
    std::vector<Visitor> out;
    while (visitors_.size() > max_) {
      out.push_back(std::move(visitors_.front()));
      visitors_.pop_front();
    }
    return out;
  }

  // Lets the client read our last words and close the connection, for a second at most.
  void close_gracefully(const std::shared_ptr<ControlStream>& stream, TimePoint now) {
    stream->finish();
    for (const Visitor& pushed_out : enter({stream, now + kFarewell, true})) pushed_out.stream->close();
  }

  // False: it was not here.
  bool remove(const ControlStream* stream) {
    return std::erase_if(visitors_, [&](const Visitor& v) { return v.stream.get() == stream; }) > 0;
  }

  // Here, and not on the way out.
  bool hosts(const ControlStream* stream) const {
    return std::any_of(visitors_.begin(), visitors_.end(),
                       [&](const Visitor& v) { return v.stream.get() == stream && !v.leaving; });
  }

  // Takes out those whose time is over and those who have left.
  std::vector<Visitor> expire(TimePoint now) {
    std::vector<Visitor> out;
    std::erase_if(visitors_, [&](Visitor& v) {
      if (v.deadline > now && v.stream->is_open()) return false;
      out.push_back(std::move(v));
      return true;
    });
    return out;
  }

  size_t size() const { return visitors_.size(); }

 private:
  static constexpr auto kFarewell = std::chrono::seconds(1);

  size_t max_;
  std::list<Visitor> visitors_;  // oldest first
};

}  // namespace gnomon::daemon
