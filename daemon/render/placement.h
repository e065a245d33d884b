// Which session lives on which device. Pure bookkeeping: no locks, one thread at a time.
//
// A session goes where least is asked for, and stays until its device closes or another one opens again. A load is what
// it asks of a device: pixels x lights x frames a second.
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

  // On an open device; where all are closed, on one that is not gone for ever: it may come back. Empty: all are gone.
  std::optional<uint32_t> add(SessionId session, TenantId tenant, double load);
  void remove(SessionId session);
  // Empty: no such session.
  std::optional<uint32_t> device_of(SessionId session) const;

  // The device takes no sessions from now on. Gives those that move to others: none where no other is open.
  std::vector<Move> close(uint32_t device);
  // The same, and it never opens again.
  std::vector<Move> close_for_ever(uint32_t device);
  // It takes sessions again. Gives those that move to it, so that all open ones have about the same to do.
  std::vector<Move> open(uint32_t device);

  bool is_open(uint32_t device) const { return devices_[device].open; }
  uint32_t sessions(uint32_t device) const { return devices_[device].all.sessions; }
  // Of what the tenant asks for, what it asks of this device: 0 to 1.
  double part(uint32_t device, TenantId tenant) const;

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
