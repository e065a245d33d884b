// Which device serves which session, and the moves when a device is lost, drained or back.
#pragma once

#include <memory>
#include <unordered_map>
#include <vector>

#include "daemon/render/device_thread.h"
#include "daemon/render/placement.h"

namespace gnomon::daemon {

// Pushes the changes into the devices' inboxes; a session that moves is opened on the new device before it leaves the
// old one. One thread at a time: DevicePool guards it with its mutex.
class SessionPlaces {
 public:
  // `devices` outlive this object; their number does not change. `assumed_rate_hz`: of sessions that named no rate, in
  // demands and loads.
  using Devices = std::vector<std::unique_ptr<DeviceThread>>;
  SessionPlaces(const Devices& devices, double assumed_rate_hz);

  void open(const SessionOpened& session);
  void close(SessionId session);
  // The inbox of the session's device; of the first device if the session is not known.
  RenderInbox& inbox_of(SessionId session) const;

  // The device's sessions move to other devices, if there are any, or some move back to it.
  void set_drained(uint32_t device, bool drained);
  void set_down(uint32_t device, bool down);
  void set_gone(uint32_t device);  // for ever

  bool drained(uint32_t device) const { return drained_[device]; }
  bool any_other_open(uint32_t device) const;  // whether another device takes sessions
  uint32_t sessions(uint32_t device) const { return placement_.sessions(device); }
  // For each device: the seconds a second that its sessions' frames are predicted to need, by what they were granted. A
  // scene of which nothing is known yet counts nothing.
  std::vector<double> loads(const CostModels& known) const;
  std::vector<RenderInbox*> open_inboxes() const;  // of the devices that take sessions

 private:
  void settle(uint32_t device);
  void carry_out(const std::vector<Placement::Move>& moves);
  void tell_parts(TenantId tenant);

  double demand_of(const SessionGrant& grant) const;  // visibility bits a second

  const Devices& devices_;
  const double assumed_rate_hz_;
  Placement placement_;
  std::unordered_map<SessionId, SessionOpened> sessions_;
  std::vector<bool> drained_, down_;
};

}  // namespace gnomon::daemon
