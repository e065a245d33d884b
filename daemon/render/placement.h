// Assigns sessions to devices. Pure bookkeeping: no locks, one thread at a time.
//
// A session is placed on the device with the least load, and stays until that device closes or another one opens again.
// Load is the demand of a session: pixels x lights x frames a second.
#pragma once

#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include "common/ids.h"

namespace gnomon::daemon {

class Placement {
 public:
  struct Move {
    SessionId session;
    uint32_t from = 0, to = 0;
  };

  explicit Placement(uint32_t devices) : devices_(devices) {}

  // Places the session on an open device; if all are closed, on one that may open again. Returns the device, nullopt if
  // all are closed for ever.
  std::optional<uint32_t> add(SessionId session, TenantId tenant, double load);
  void remove(SessionId session);
  // nullopt if there is no such session.
  std::optional<uint32_t> device_of(SessionId session) const;

  // The device takes no sessions from now on. Returns the sessions that move to others; none if no other is open.
  std::vector<Move> close(uint32_t device);
  // As close(), and the device never opens again.
  std::vector<Move> close_for_ever(uint32_t device);
  // The device takes sessions again. Returns the sessions that move to it, so that open devices have a similar load.
  std::vector<Move> open(uint32_t device);

  bool is_open(uint32_t device) const { return devices_[device].open; }
  uint32_t sessions(uint32_t device) const { return devices_[device].all.sessions; }
  // The share of the tenant's load that is on this device: 0 to 1; 0 if the tenant has no load.
  double fraction(uint32_t device, TenantId tenant) const;

 private:
  struct Sum {
    double load = 0;
    uint32_t sessions = 0;
    void add(double more);
    void remove(double less);
  };
  struct Device {
    bool open = true, gone = false;
    Sum all;
    std::unordered_map<TenantId, Sum> of_tenant;
  };
  struct Placed {
    TenantId tenant;
    double load = 0;
    uint32_t device = 0;
  };

  std::optional<uint32_t> least_loaded() const;
  void put(const Placed& placed);
  void take(const Placed& placed);
  Move move(SessionId session, Placed& placed, uint32_t to);

  std::vector<Device> devices_;
  std::unordered_map<SessionId, Placed> sessions_;
};

}  // namespace gnomon::daemon
