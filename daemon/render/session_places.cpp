#include "daemon/render/session_places.h"

#include <algorithm>

namespace gnomon::daemon {
namespace {

uint64_t bits_of(const SessionGrant& grant, uint64_t pixels, uint32_t lights) {
  return scheduler::weighted_bits(pixels, lights, grant.area_count(), grant.samples);
}

}  // namespace

SessionPlaces::SessionPlaces(const Devices& devices, double assumed_rate_hz)
    : devices_(devices),
      assumed_rate_hz_(assumed_rate_hz),
      placement_(static_cast<uint32_t>(devices.size())),
      drained_(devices.size()),
      down_(devices.size()) {}

void SessionPlaces::open(const SessionOpened& session) {
  const TenantId tenant = session.grant.tenant;
  if (!placement_.add(session.session, tenant, demand_of(session.grant))) return;
  sessions_.emplace(session.session, session);
  inbox_of(session.session).push(session);
  tell_parts(tenant);
}

void SessionPlaces::close(SessionId session) {
  inbox_of(session).push(SessionClosed{session});
  placement_.remove(session);
  const auto found = sessions_.find(session);
  if (found == sessions_.end()) return;
  const TenantId tenant = found->second.grant.tenant;
  sessions_.erase(found);
  tell_parts(tenant);
}

double SessionPlaces::demand_of(const SessionGrant& grant) const {
  const double rate = grant.rate_hz > 0 ? grant.rate_hz : assumed_rate_hz_;
  const uint64_t pixels = uint64_t{grant.width} * grant.height;
  return rate * static_cast<double>(bits_of(grant, pixels, std::max(grant.lights, 1u)));
}

RenderInbox& SessionPlaces::inbox_of(SessionId session) const {
  return devices_[placement_.device_of(session).value_or(0)]->inbox();
}

std::vector<double> SessionPlaces::loads(const CostModels& known) const {
  std::vector<double> all(devices_.size());
  for (const auto& [id, placed] : sessions_) {
    const SessionGrant& grant = placed.grant;
    const auto model = known.find(grant.scene);
    const auto device = placement_.device_of(id);
    if (!device || model == known.end() || !model->second.model(grant.samples).knows()) continue;
    const uint64_t pixels = uint64_t{grant.width} * grant.height;
    const double rate_hz = grant.rate_hz > 0 ? double{grant.rate_hz} : assumed_rate_hz_;
    const scheduler::Work frame{pixels, bits_of(grant, pixels, grant.lights), true};
    all[*device] += rate_hz * to_seconds(model->second.model(grant.samples).predict_within_reach(frame).total());
  }
  return all;
}

std::vector<RenderInbox*> SessionPlaces::open_inboxes() const {
  std::vector<RenderInbox*> open;
  for (uint32_t i = 0; i < devices_.size(); ++i)
    if (placement_.is_open(i)) open.push_back(&devices_[i]->inbox());
  return open;
}

bool SessionPlaces::any_other_open(uint32_t device) const {
  for (uint32_t i = 0; i < devices_.size(); ++i)
    if (i != device && placement_.is_open(i)) return true;
  return false;
}

void SessionPlaces::set_drained(uint32_t device, bool drained) {
  drained_[device] = drained;
  settle(device);
}

void SessionPlaces::set_down(uint32_t device, bool down) {
  down_[device] = down;
  settle(device);
}

void SessionPlaces::set_gone(uint32_t device) {
  down_[device] = true;
  carry_out(placement_.close_for_ever(device));
}

void SessionPlaces::settle(uint32_t device) {
  const bool open = !drained_[device] && !down_[device];
  if (open != placement_.is_open(device)) carry_out(open ? placement_.open(device) : placement_.close(device));
}

void SessionPlaces::carry_out(const std::vector<Placement::Move>& moves) {
  std::vector<TenantId> tenants;
  for (const Placement::Move& move : moves) {
    const SessionOpened& opened = sessions_.at(move.session);
    RenderInbox& to = devices_[move.to]->inbox();
    to.push(opened);
    devices_[move.from]->inbox().push(SessionMoved{move.session, &to});
    tenants.push_back(opened.grant.tenant);
  }
  std::sort(tenants.begin(), tenants.end());
  tenants.erase(std::unique(tenants.begin(), tenants.end()), tenants.end());
  for (const TenantId tenant : tenants) tell_parts(tenant);
  if (!moves.empty())
    log::info("sessions moved", {{"from", moves.front().from}, {"to", moves.front().to}, {"count", moves.size()}});
}

// A tenant's limits hold for all devices together: each device allows its share of the tenant's load.
void SessionPlaces::tell_parts(TenantId tenant) {
  if (devices_.size() == 1) return;
  for (uint32_t i = 0; i < devices_.size(); ++i)
    devices_[i]->inbox().push(TenantDeviceShare{tenant, placement_.fraction(i, tenant)});
}

}  // namespace gnomon::daemon
