// What a simulated link does to packets, and how people write it: "delay=50ms,loss=2%,rate=20mbit".
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
  Nanoseconds jitter{};  // evenly within delay - jitter and delay + jitter; packets keep their order
  double loss = 0;       // each packet by itself
  // Bursts, after Gilbert (1960): a link that is well goes bad with `burst_enter`, recovers with `burst_leave`, and
  // loses everything in between. Both are chances for each packet.
  double burst_enter = 0;
  double burst_leave = 1;
  double reorder = 0;  // delayed by `reorder_by` more, so that later packets overtake
  Nanoseconds reorder_by = std::chrono::milliseconds(10);
  double duplicate = 0;
  double rate_bit_per_s = 0;  // 0: no limit
  // Waiting room of a limited link: what would wait longer, or find more bytes before it, is dropped.
  Nanoseconds queue = std::chrono::milliseconds(100);
  size_t queue_bytes = 0;  // 0: `queue` alone counts
  size_t mtu = 0;          // datagrams with a longer payload are dropped; 0: none are
  bool udp = true;         // false: datagrams are dropped, as a firewall does; connections pass
  friend bool operator==(const Profile&, const Profile&) = default;
};

// A link whose profile changes: each holds from its time on. Without a phase at 0 the plain profile holds until then.
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
