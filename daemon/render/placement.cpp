#include "daemon/render/placement.h"

#include <algorithm>
#include <utility>

namespace gnomon::daemon {

std::optional<uint32_t> Placement::least_loaded() const {
  std::optional<uint32_t> best;
  for (const bool only_open : {true, false}) {
    for (uint32_t i = 0; i < devices_.size(); ++i) {
      const Device& device = devices_[i];
      if (device.gone || (only_open && !device.open)) continue;
      if (!best || device.all.load < devices_[*best].all.load) best = i;
    }
    if (best) break;
  }
  return best;
}

void Placement::Sum::add(double more) {
  load += more;
  ++sessions;
}

// The sum is reset when it is empty, as rounding errors may leave a remainder.
void Placement::Sum::remove(double less) { load = --sessions == 0 ? 0 : load - less; }

void Placement::put(const Placed& placed) {
  Device& device = devices_[placed.device];
  device.all.add(placed.load);
  device.of_tenant[placed.tenant].add(placed.load);
}

void Placement::take(const Placed& placed) {
  Device& device = devices_[placed.device];
  device.all.remove(placed.load);
  device.of_tenant[placed.tenant].remove(placed.load);
}

std::optional<uint32_t> Placement::add(SessionId session, TenantId tenant, double load) {
  const auto device = least_loaded();
  if (!device) return std::nullopt;
  const Placed placed{tenant, load, *device};
  put(placed);
  sessions_[session] = placed;
  return device;
}

void Placement::remove(SessionId session) {
  const auto found = sessions_.find(session);
  if (found == sessions_.end()) return;
  take(found->second);
  sessions_.erase(found);
}

std::optional<uint32_t> Placement::device_of(SessionId session) const {
  const auto found = sessions_.find(session);
  if (found == sessions_.end()) return std::nullopt;
  return found->second.device;
}

Placement::Move Placement::move(SessionId session, Placed& placed, uint32_t to) {
  const uint32_t from = placed.device;
  take(placed);
  placed.device = to;
  put(placed);
  return {session, from, to};
}

std::vector<Placement::Move> Placement::close(uint32_t device) {
  devices_[device].open = false;
  std::vector<Move> moves;
  for (auto& [session, placed] : sessions_) {
    if (placed.device != device) continue;
    const auto to = least_loaded();
    if (to && *to != device && devices_[*to].open) moves.push_back(move(session, placed, *to));
  }
  return moves;
}

std::vector<Placement::Move> Placement::close_for_ever(uint32_t device) {
  devices_[device].gone = true;
  return close(device);
}

std::vector<Placement::Move> Placement::open(uint32_t device) {
  std::vector<Move> moves;
  if (devices_[device].gone || std::exchange(devices_[device].open, true)) return moves;
  for (auto& [session, placed] : sessions_) {
    if (placed.device == device) continue;
    const bool closed = !devices_[placed.device].open;
    const double there = devices_[placed.device].all.load - placed.load,
                 here = devices_[device].all.load + placed.load;
    if (closed || here <= there) moves.push_back(move(session, placed, device));
  }
  return moves;
}

double Placement::fraction(uint32_t device, TenantId tenant) const {
  double all = 0, here = 0;
  for (uint32_t i = 0; i < devices_.size(); ++i) {
    const auto found = devices_[i].of_tenant.find(tenant);
    if (found == devices_[i].of_tenant.end()) continue;
    all += found->second.load;
    if (i == device) here = found->second.load;
  }
  return all > 0 ? std::clamp(here / all, 0.0, 1.0) : 0;
}

}  // namespace gnomon::daemon
