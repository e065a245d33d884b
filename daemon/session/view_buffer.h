// The newest view of a session, held back while the link has no room for its frame. A newer view replaces it.
#pragma once

#include <optional>
#include <utility>

#include "daemon/frame/frame.h"
#include "daemon/link/link_sender.h"
#include "daemon/link/link_window.h"

namespace gnomon::daemon {

// Belongs to its session; outlived by the session's link.
class ViewBuffer {
 public:
  explicit ViewBuffer(LinkSender& link) : link_(link) {}
  ViewBuffer(ViewBuffer&&) = delete;

  // A view that has just arrived. Returns it if the link has room for it; otherwise it is held back, and nullopt is
  // returned.
  std::optional<ViewRequest> offer(ViewRequest view, TimePoint now);

  // Keeps a view that has just arrived, in the place of the one that was held back.
  void withhold(ViewRequest view);

  // Returns the view that was held back, if the link has room for it now; nullopt otherwise.
  std::optional<ViewRequest> take(TimePoint now);

  // When take() should be called again; TimePoint::max() if no view is held back.
  TimePoint take_at(TimePoint now) const { return held_ ? link_.may_request_at(now) : TimePoint::max(); }

  // The views since the last call.
  LinkWindow take_window() { return std::exchange(window_, {}); }

 private:
  ViewRequest release(ViewRequest view, TimePoint now);

  LinkSender& link_;
  std::optional<ViewRequest> held_;
  LinkWindow window_;
};

}  // namespace gnomon::daemon
