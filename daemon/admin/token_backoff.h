// How long who has shown wrong tokens has to wait before the next one is looked at: kFree are free, then a second, and
// twice as long after each further one up to kLongest. Networks that show none for kForgotten are forgotten.
//
// One thread at a time; the caller passes the time.
#pragma once

#include <chrono>
#include <map>
#include <optional>
#include <string>

#include "common/clock.h"

namespace gnomon::daemon {

class TokenBackoff {
 public:
  static constexpr uint32_t kFree = 3;
  static constexpr std::chrono::seconds kLongest{300};
  static constexpr std::chrono::seconds kForgotten{900};
  // Networks that are remembered. Beyond it the one whose wait ends first is forgotten, so that an attacker with many
  // addresses gains a few tokens an address and no more.
  static constexpr size_t kMostNetworks = 4096;

  // `network`: of the caller. Nullopt if a token of it may be looked at.
  std::optional<std::chrono::seconds> wait(const std::string& network, TimePoint now) const;
  void wrong(const std::string& network, TimePoint now);
  void right(const std::string& network) { known_.erase(network); }

  size_t size() const { return known_.size(); }

 private:
  struct Account {
    uint32_t wrong = 0;
    TimePoint until, last;
  };
  void make_room(TimePoint now);

  std::map<std::string, Account> known_;
};

}  // namespace gnomon::daemon
