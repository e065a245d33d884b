#include "daemon/net/connection_rate.h"

#include <algorithm>
#include <functional>
#include <vector>

namespace gnomon::daemon {
namespace {

// So many are forgotten together that a flood of fresh addresses pays for sorting once in a thousand connections.
constexpr size_t kForgottenTogether = ConnectionRate::kMaxNetworks / 8;

}  // namespace

double ConnectionRate::left(const Account& account, TimePoint now) const {
  return std::min(at_once_, account.left + per_second_ * to_seconds(now - account.counted));
}

bool ConnectionRate::admit(const ClientNetwork& network, TimePoint now) {
  if (saved_.size() >= kMaxNetworks && !saved_.contains(network)) make_room(now);
  Account& account = saved_.try_emplace(network, Account{at_once_, now}).first->second;
  account = {left(account, now), now};
  if (account.left < 1) return false;
  account.left -= 1;
  return true;
}

// To forget a network is to give it its whole allowance again.
void ConnectionRate::make_room(TimePoint now) {
  std::vector<double> most_first;
  for (const auto& [network, account] : saved_) most_first.push_back(left(account, now));
  const auto last = most_first.begin() + kForgottenTogether - 1;
  std::nth_element(most_first.begin(), last, most_first.end(), std::greater<>());
  size_t forgotten = 0;
  std::erase_if(saved_, [&, least = *last](const auto& entry) {
    return forgotten < kForgottenTogether && left(entry.second, now) >= least && ++forgotten > 0;
  });
}

}  // namespace gnomon::daemon
