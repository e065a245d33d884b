// The sessions of one net thread, by the id that routes their datagrams.
#pragma once

#include <memory>
#include <unordered_map>
#include <vector>

#include "daemon/session/session.h"

namespace gnomon::daemon {

class SessionTable {
 public:
  Session& add(std::unique_ptr<Session> session) {
    return *sessions_.emplace(session->id(), std::move(session)).first->second;
  }

  void remove(SessionId id) { sessions_.erase(id); }

  Session* find(SessionId id) const {
    const auto found = sessions_.find(id);
    return found == sessions_.end() ? nullptr : found->second.get();
  }

  // Sessions whose client has sent nothing since `limit`.
  std::vector<SessionId> silent_since(TimePoint limit) const {
    std::vector<SessionId> silent;
    for (const auto& [id, session] : sessions_) {
      if (session->last_received() < limit) silent.push_back(id);
    }
    return silent;
  }

  // Sessions without a control connection whose time to be resumed has passed.
  std::vector<SessionId> not_resumed(TimePoint now) const {
    std::vector<SessionId> waited;
    for (const auto& [id, session] : sessions_) {
      if (session->resumed_until() <= now) waited.push_back(id);
    }
    return waited;
  }

  size_t size() const { return sessions_.size(); }
  auto begin() const { return sessions_.begin(); }
  auto end() const { return sessions_.end(); }

 private:
  std::unordered_map<SessionId, std::unique_ptr<Session>> sessions_;
};

}  // namespace gnomon::daemon
