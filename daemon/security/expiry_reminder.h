// When operators are reminded of a certificate that expires: once a day, from 30 days before. Pure: it is told the time.
#pragma once

#include <chrono>
#include <optional>

namespace gnomon::daemon {

class ExpiryReminder {
 public:
  static constexpr std::chrono::days kAhead{30};

  // Returns the whole days that are left if it is time for a reminder, negative once the certificate has expired;
  // nullopt otherwise.
  std::optional<std::chrono::days> due(std::chrono::sys_seconds expires, std::chrono::sys_seconds now) {
    if (expires - now > kAhead || (expires == told_ && now < next_)) return std::nullopt;
    told_ = expires;
    next_ = now + std::chrono::days(1);
    return std::chrono::floor<std::chrono::days>(expires - now);
  }

 private:
  std::chrono::sys_seconds told_ = std::chrono::sys_seconds::min();  // another one is told of at once
  std::chrono::sys_seconds next_ = std::chrono::sys_seconds::min();
};

}  // namespace gnomon::daemon
