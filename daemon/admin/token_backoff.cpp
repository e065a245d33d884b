#include "daemon/admin/token_backoff.h"

#include <algorithm>

namespace gnomon::daemon {

using namespace std::chrono_literals;

std::optional<std::chrono::seconds> TokenBackoff::wait(const std::string& network, TimePoint now) const {
  const auto found = known_.find(network);
  if (found == known_.end() || found->second.until <= now) return std::nullopt;
  return std::chrono::ceil<std::chrono::seconds>(found->second.until - now);
}

void TokenBackoff::wrong(const std::string& network, TimePoint now) {
  if (known_.size() >= kMostNetworks && !known_.contains(network)) make_room(now);
  Account& account = known_[network];
  if (account.wrong > 0 && now - account.last > kForgotten) account = {};
  account.last = now;
  if (++account.wrong <= kFree) {
    account.until = now;
    return;
  }
  constexpr uint32_t kMostDoublings = 16;  // beyond kLongest
  const auto doubled = 1s * (1u << std::min(account.wrong - kFree - 1, kMostDoublings));
  account.until = now + std::min<std::chrono::seconds>(doubled, kLongest);
}

void TokenBackoff::make_room(TimePoint now) {
  std::erase_if(known_, [&](const auto& entry) { return now - entry.second.last > kForgotten; });
  if (known_.size() < kMostNetworks) return;
  known_.erase(std::min_element(known_.begin(), known_.end(),
                                [](const auto& a, const auto& b) { return a.second.until < b.second.until; }));
}

}  // namespace gnomon::daemon
