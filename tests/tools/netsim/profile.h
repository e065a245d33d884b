// What a simulated link does to packets, and its notation: "delay=50ms,loss=2%,rate=20mbit".
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/clock.h"
#include "common/result.h"

namespace gnomon::netsim {

// One direction. Shares are of packets, 0 to 1.
struct Profile {
  Nanoseconds delay{};
  Nanoseconds jitter{};  // uniform between delay - jitter and delay + jitter; packets keep their order
  double loss = 0;       // of each packet independently
  // Bursts, after Gilbert (1960): a good link turns bad with probability `burst_enter` at each packet, turns good again
  // with probability `burst_leave`, and loses every packet in between.
  double burst_enter = 0;
  double burst_leave = 1;
  double reorder = 0;  // delayed by `reorder_by` more, so that later packets overtake
  Nanoseconds reorder_by = std::chrono::milliseconds(10);
  double duplicate = 0;
  double rate_bit_per_s = 0;  // 0: no limit
  // Queue of a limited link: a packet that would wait longer, or that does not fit into `queue_bytes`, is dropped.
  Nanoseconds queue = std::chrono::milliseconds(100);
  size_t queue_bytes = 0;  // 0: only `queue` limits
  size_t mtu = 0;          // datagrams with a longer payload are dropped; 0: none are
  bool udp = true;         // false: datagrams are dropped, as a firewall does; connections pass
  friend bool operator==(const Profile&, const Profile&) = default;
};

// A link whose profile changes: each profile applies from its time on, the first one also before its time.
struct Phase {
  Nanoseconds from{};
  Profile profile;
};
using Schedule = std::vector<Phase>;  // by increasing time, not empty

// Sets what `text` names: delay, jitter, loss, burst (ENTER:LEAVE), reorder, reorder_by, duplicate, rate, queue (a
// time or bytes), mtu, udp (on or off). The error names the key, the value and what is allowed.
Result<void> apply(std::string_view text, Profile& profile);

// "50ms", "1.5s", "200us"; "2%", "0.02"; "20mbit", "500kbit".
Result<Nanoseconds> parse_time(std::string_view text);
Result<double> parse_share(std::string_view text);
Result<double> parse_rate(std::string_view text);

}  // namespace gnomon::netsim
