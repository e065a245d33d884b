#include "daemon/session/view_buffer.h"

namespace gnomon::daemon {

std::optional<ViewRequest> ViewBuffer::offer(ViewRequest view, TimePoint now) {
  ++window_.offered;
  if (held_) view.coalesced = held_->coalesced + 1;
  if (link_.may_request(now)) return release(view, now);
  held_ = view;
  return std::nullopt;
}

void ViewBuffer::withhold(ViewRequest view) {
  ++window_.offered;
  if (held_) view.coalesced = held_->coalesced + 1;
  held_ = view;
}

std::optional<ViewRequest> ViewBuffer::take(TimePoint now) {
  if (!held_ || !link_.may_request(now)) return std::nullopt;
  return release(*held_, now);
}

ViewRequest ViewBuffer::release(ViewRequest view, TimePoint now) {
  held_.reset();
  ++window_.taken;
  link_.on_request(view.frame, now);
  view.slice_body_bytes = link_.slice_body_bytes();
  return view;
}

}  // namespace gnomon::daemon
