#include "client/stream/requested_frames.h"

#include <algorithm>

namespace gnomon::client {

FrameId RequestedFrames::add(const protocol::CameraView& camera, TimePoint now, uint32_t index) {
  requests_.push_back({camera, now, index, {}, false});
  return newest_ = FrameId{newest_.value + 1};
}

void RequestedFrames::answered(FrameId frame) {
  find(frame)->answered = true;
  newest_answered_ = std::max(newest_answered_, frame);
}

RequestedFrames::Request* RequestedFrames::find(FrameId frame) {
  const uint32_t back = newest_.value - frame.value;
  return back < requests_.size() ? &requests_[requests_.size() - 1 - back] : nullptr;
}

std::vector<FrameId> RequestedFrames::overdue(TimePoint now, Nanoseconds patience) const {
  std::vector<FrameId> found;
  for (size_t i = 0; i < requests_.size(); ++i) {
    const Request& request = requests_[i];
    if (request.answered || !request.last_slice || now - *request.last_slice < patience) continue;
    found.push_back(FrameId{oldest().value + static_cast<uint32_t>(i)});
  }
  return found;
}

RequestedFrames::Dropped RequestedFrames::drop_old(TimePoint now, Nanoseconds timeout) {
  Dropped dropped;
  while (!requests_.empty() && (requests_.front().answered || now - requests_.front().sent >= timeout)) {
    if (!requests_.front().answered) {
      ++(oldest() < newest_answered_ ? dropped.superseded : dropped.unanswered);
    }
    requests_.pop_front();
  }
  return dropped;
}

}  // namespace gnomon::client
