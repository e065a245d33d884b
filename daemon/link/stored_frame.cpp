#include "daemon/link/stored_frame.h"

#include <algorithm>

#include "daemon/link/parity_plan.h"

namespace gnomon::daemon {
namespace {

constexpr Nanoseconds kClientPatience = std::chrono::milliseconds(200);
constexpr size_t kMostPadding = 8;  // a slice is padded by at most 1/8 of the longest payload

size_t longest_payload(const protocol::EncodedMask& slices) {
  size_t longest = 0;
  for (size_t i = 0; i < slices.slices.size(); ++i) longest = std::max(longest, slices.payload(i).size());
  return longest;
}

}  // namespace

StoredFrame::StoredFrame(const protocol::EncodedMask& slices, uint64_t answer, TimePoint deadline, bool pad)
    : frame_(slices.slices.front().frame), answer_(answer), deadline_(deadline), state_(slices.slices.size()) {
  constexpr size_t kMostHeader =
      protocol::kSliceHeaderBytes + protocol::kMomentBytes + protocol::kSizeBytes + protocol::kSamplesBytes;
  bytes_.reserve(slices.bytes.size() + slices.slices.size() * kMostHeader);
  const size_t longest = longest_payload(slices);
  for (size_t i = 0; i < slices.slices.size(); ++i) {
    protocol::SliceHeader header = slices.slices[i];
    const size_t short_of = longest - slices.payload(i).size();
    if (pad && short_of > 0 && short_of <= longest / kMostPadding) {
      header.flags |= protocol::kSliceIsPadded;
      header.padding = static_cast<uint16_t>(short_of);
    }
    protocol::append_frame_slice(bytes_, header, slices.payload(i));
    bytes_.resize(bytes_.size() + header.padding);
    offsets_.push_back(bytes_.size());
  }
}

TimePoint StoredFrame::useful_until() const {
  if (deadline_ != TimePoint::max() || last_sent_ == TimePoint::max()) return deadline_;
  return last_sent_ + kClientPatience;
}

void StoredFrame::protect(double loss) {
  groups_ = static_cast<uint16_t>(parity_groups(slice_count()));
  for (uint16_t group = 0; group < groups_; ++group) {
    protocol::Bodies bodies;
    for (size_t slice = group; slice < slice_count(); slice += groups_) {
      bodies.push_back(body(static_cast<uint16_t>(slice)));
    }
    protocol::ParityHeader header{frame_, static_cast<uint16_t>(slice_count()), groups_, group, 0, 0};
    for (const auto& shard : protocol::make_parity(bodies, daemon::parity_count(bodies.size(), loss))) {
      parity_.push_back({{}, group});
      protocol::append_parity(parity_.back().body, header, shard);
      ++header.index;
    }
  }
}

bool StoredFrame::slice_lost(uint16_t slice) {
  if (state_[slice] == State::arrived) return false;
  state_[slice] = State::lost;
  if (parity_.empty()) return true;
  const auto group = static_cast<uint16_t>(slice % groups_);
  size_t lost = 0;
  for (size_t s = group; s < slice_count(); s += groups_) lost += state_[s] == State::lost;
  const auto alive =
      std::count_if(parity_.begin(), parity_.end(), [&](const Parity& p) { return p.group == group && !p.lost; });
  return lost > static_cast<size_t>(alive);
}

}  // namespace gnomon::daemon
