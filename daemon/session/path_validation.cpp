#include "daemon/session/path_validation.h"

#include <algorithm>

namespace gnomon::daemon {

void PathValidation::received(const Endpoint& from, size_t bytes, bool newest, bool streams, TimePoint now) {
  if (current_ == from) {
    // The client is still, or again, where it was (RFC 9000, 9.3.2: a copy of its datagram came from elsewhere).
    if (newest) candidate_.reset();
    return;
  }
  const bool known = candidate_ && candidate_->address == from;
  if (!known && !(newest && (streams || !current_))) return;
  if (!validates_) {
    if (streams) current_ = from;
    return;
  }
  if (!known) candidate_ = Candidate{.address = from, .began = now, .next = now};
  candidate_->received += bytes;
  candidate_->streams = candidate_->streams || streams;
}

void PathValidation::sent(const Endpoint& to, size_t bytes) {
  if (candidate_ && candidate_->address == to) candidate_->sent += bytes;
}

bool PathValidation::may_challenge() const {
  return candidate_->tries < kTries &&
         candidate_->sent + kChallengeBytes <= kMostAmplification * candidate_->received;
}

std::optional<PathValidation::Challenge> PathValidation::challenge_due(TimePoint now) {
  if (!candidate_ || now < candidate_->next || !may_challenge()) return std::nullopt;
  const uint64_t token = random_();
  candidate_->tokens[candidate_->tries] = token;
  candidate_->next = now + kFirstWait * (1 << candidate_->tries);
  ++candidate_->tries;
  candidate_->sent += kChallengeBytes;
  return Challenge{candidate_->address, token};
}

std::optional<PathValidation::Move> PathValidation::answered(uint64_t token) {
  if (!candidate_) return std::nullopt;
  const auto end = candidate_->tokens.begin() + static_cast<std::ptrdiff_t>(candidate_->tries);
  if (std::find(candidate_->tokens.begin(), end, token) == end) return std::nullopt;
  const Move move{.other_host = current_ && current_->address() != candidate_->address.address(),
                  .streams = candidate_->streams};
  current_ = candidate_->address;
  candidate_.reset();
  return move;
}

bool PathValidation::take_failure(TimePoint now) {
  if (!candidate_ || now - candidate_->began < kPatience) return false;
  candidate_.reset();
  return true;
}

TimePoint PathValidation::wake_at() const {
  if (!candidate_) return TimePoint::max();
  const TimePoint given_up = candidate_->began + kPatience;
  return may_challenge() ? std::min(candidate_->next, given_up) : given_up;
}

}  // namespace gnomon::daemon
