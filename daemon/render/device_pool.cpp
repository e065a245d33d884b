#include "daemon/render/device_pool.h"

#include <algorithm>
#include <atomic>

namespace gnomon::daemon {
namespace {

// Sessions that ask for no rate take what is left: like those of a fast screen.
constexpr double kRateOfTheGreedy = 60;

double load_of(const SessionGrant& grant) {
  const double rate = grant.rate_hz > 0 ? grant.rate_hz : kRateOfTheGreedy;
  return rate * grant.width * grant.height * std::max(grant.lights, 1u);
}

// What several devices answer to one question.
struct Answers {
  std::atomic<size_t> left;
  std::mutex mutex;
  Result<gpu::SceneFootprint> best = Error{"no device takes it"};  // guarded by mutex
};

// Devices' figures of one tenant beside each other.
void add(TenantReport& sum, const TenantReport& more) {
  sum.service += more.service;
  sum.share += more.share;
  sum.expected_share += more.expected_share;
  sum.lag += more.lag;
  sum.predicted_error = std::max(sum.predicted_error, more.predicted_error);
}

}  // namespace

DevicePool::DevicePool(size_t count, Metrics& metrics, Health& health)
    : metrics_(metrics), health_(health), placement_(static_cast<uint32_t>(count)), drained_(count), down_(count) {
  for (uint32_t i = 0; i < count; ++i)
    devices_.push_back(std::make_unique<DeviceThread>(i, metrics, static_cast<Owner&>(*this)));
}

Result<void> DevicePool::start(const std::vector<RendererFactory>& factories, const Terms& terms,
                               const SceneMotion::Settings& motion, FrameSink& sink,
                               std::function<void(const Error&)> failed) {
  failed_ = std::move(failed);
  for (uint32_t i = 0; i < devices_.size(); ++i) {
    if (auto started = devices_[i]->start(factories[i], terms, motion, sink); !started) return started;
    metrics_.device_up(i, true);
  }
  health_.device_up = true;
  return {};
}

void DevicePool::stop() {
  for (const auto& device : devices_) device->inbox().push(StopRendering{});
  for (const auto& device : devices_) device->stop();
}

std::vector<PooledDevice> DevicePool::report() const {
  std::lock_guard lock(mutex_);
  std::vector<PooledDevice> all;
  for (uint32_t i = 0; i < devices_.size(); ++i)
    all.push_back({devices_[i]->info(), devices_[i]->up(), drained_[i], placement_.sessions(i)});
  return all;
}

ShareReport DevicePool::shares() const {
  ShareReport sum = *devices_.front()->shares();
  for (size_t d = 1; d < devices_.size(); ++d) {
    const auto more = devices_[d]->shares();
    sum.tenants.resize(std::max(sum.tenants.size(), more->tenants.size()));
    for (size_t i = 0; i < more->tenants.size(); ++i) add(sum.tenants[i], more->tenants[i]);
    sum.jain = std::min(sum.jain, more->jain);
    sum.worst_lag = std::max(sum.worst_lag, more->worst_lag);
  }
  for (TenantReport& tenant : sum.tenants) {
    tenant.share /= static_cast<double>(devices_.size());
    tenant.expected_share /= static_cast<double>(devices_.size());
  }
  return sum;
}

// Of a scene what the first device learned that rendered it.
CostModels DevicePool::costs() const {
  CostModels all;
  for (const auto& device : devices_) {
    CostModels more = *device->costs();
    all.merge(more);
  }
  return all;
}

SceneReports DevicePool::scenes() const {
  SceneReports all;
  for (const auto& device : devices_) {
    for (const auto& [id, scene] : *device->scenes()) {
      const auto [known, is_new] = all.emplace(id, scene);
      if (!is_new && scene.built_share() < known->second.built_share()) known->second = scene;
    }
  }
  return all;
}

std::vector<Heartbeat*> DevicePool::heartbeats() {
  std::vector<Heartbeat*> all;
  for (const auto& device : devices_) all.push_back(&device->heartbeat());
  return all;
}

RenderInbox& DevicePool::inbox_of(SessionId session) const {
  return devices_[placement_.device_of(session).value_or(0)]->inbox();
}

bool DevicePool::push_view(const ViewRequest& view) {
  if (devices_.size() == 1) return devices_.front()->inbox().push_view(view);
  std::lock_guard lock(mutex_);
  return inbox_of(view.session).push_view(view);
}

void DevicePool::ask_room(const RoomAsked& asked) {
  struct Answered {
    std::atomic<size_t> left;
    std::atomic<bool> done{false};
  };
  auto answered = std::make_shared<Answered>();
  std::vector<RenderInbox*> inboxes;
  {
    std::lock_guard lock(mutex_);
    for (uint32_t i = 0; i < devices_.size(); ++i)
      if (placement_.is_open(i)) inboxes.push_back(&devices_[i]->inbox());
  }
  if (inboxes.empty()) return asked.answer({});
  answered->left = inboxes.size();
  RoomAsked each = asked;
  each.answer = [answered, all = asked.answer](Result<void> one) {
    if (one && !answered->done.exchange(true)) all({});
    if (--answered->left == 0 && !answered->done.exchange(true)) all(one);
  };
  for (RenderInbox* inbox : inboxes)
    if (!inbox->push(each)) each.answer(Error{"the device is gone"});
}

void DevicePool::open(const SessionOpened& session) {
  std::lock_guard lock(mutex_);
  const TenantId tenant = session.grant.tenant;
  if (!placement_.add(session.session, tenant, load_of(session.grant))) return;
  sessions_.emplace(session.session, PooledSession{session, session.grant.codec});
  inbox_of(session.session).push(session);
  tell_parts(tenant);
}

void DevicePool::close(SessionId session) {
  std::lock_guard lock(mutex_);
  inbox_of(session).push(SessionClosed{session});
  placement_.remove(session);
  const auto found = sessions_.find(session);
  if (found == sessions_.end()) return;
  const TenantId tenant = found->second.opened.grant.tenant;
  sessions_.erase(found);
  tell_parts(tenant);
}

void DevicePool::choose_codec(const CodecChosen& chosen) {
  std::lock_guard lock(mutex_);
  if (const auto found = sessions_.find(chosen.session); found != sessions_.end())
    found->second.codec = chosen.codec;
  inbox_of(chosen.session).push(chosen);
}

void DevicePool::review(const LinkReviewed& reviewed) {
  std::lock_guard lock(mutex_);
  inbox_of(reviewed.session).push(reviewed);
}

void DevicePool::sent(uint32_t device, const BytesSent& sent) { devices_[device]->inbox().push(sent); }

void DevicePool::set_terms(const Terms& terms) {
  for (const auto& device : devices_) device->inbox().push(TermsChanged{terms});
}

// All hear of all changes in one order: what each counts is then the same.
void DevicePool::change_light(const LightChanged& change) {
  std::lock_guard lock(mutex_);
  for (const auto& device : devices_) device->inbox().push(change);
}

bool DevicePool::bring(const SceneArrived& arrived) {
  auto answers = std::make_shared<Answers>();
  answers->left = devices_.size();
  const auto answer = [answers, all = arrived.resident](Result<gpu::SceneFootprint> one) {
    {
      std::lock_guard lock(answers->mutex);
      if (one || !answers->best) answers->best = std::move(one);
    }
    if (--answers->left == 0) all(std::move(answers->best));
  };
  size_t asked = 0;
  for (const auto& device : devices_)
    asked += device->inbox().push(SceneArrived{arrived.scene, answer, arrived.name});
  if (asked == 0) return false;
  for (size_t i = asked; i < devices_.size(); ++i) answer(Error{"the device is gone"});
  return true;
}

void DevicePool::take_away(SceneId scene) {
  for (const auto& device : devices_) device->inbox().push(SceneLeaves{scene});
}

bool DevicePool::set_drained(size_t device, bool drained) {
  if (device >= devices_.size()) return false;
  std::lock_guard lock(mutex_);
  drained_[device] = drained;
  log::info(drained ? "device drained" : "device takes sessions again", {{"number", device}});
  settle(static_cast<uint32_t>(device));
  return true;
}

void DevicePool::device_changed(uint32_t device, bool up) {
  std::lock_guard lock(mutex_);
  down_[device] = !up;
  settle(device);
  metrics_.device_up(device, up);
  health_.device_up = any_up();
}

void DevicePool::device_failed(uint32_t device, const Error& why) {
  std::lock_guard lock(mutex_);
  down_[device] = true;
  settle(device, true);
  health_.device_up = any_up();
  if (any_up()) return log::error("a device is beyond repair", {{"number", device}, {"why", why.message}});
  failed_(why);
}

bool DevicePool::any_up() const {
  return std::any_of(devices_.begin(), devices_.end(), [](const auto& device) { return device->up(); });
}

// Once a second from each device: the figures of all of them together.
void DevicePool::device_reported() {
  metrics_.shares(shares());
  for (const auto& [id, scene] : scenes()) metrics_.scene_built(scene);
  if (devices_.size() == 1) return;
  std::lock_guard lock(mutex_);
  for (uint32_t i = 0; i < devices_.size(); ++i) metrics_.device_sessions(i, placement_.sessions(i));
}

// Sessions where they belong, after a device was lost, drained or came back.
void DevicePool::settle(uint32_t device, bool gone) {
  if (gone) return carry_out(placement_.close_for_ever(device));
  const bool open = !drained_[device] && !down_[device];
  if (open != placement_.is_open(device)) carry_out(open ? placement_.open(device) : placement_.close(device));
}

void DevicePool::carry_out(const std::vector<Placement::Move>& moves) {
  std::vector<TenantId> tenants;
  for (const Placement::Move& move : moves) {
    const auto& [opened, codec] = sessions_.at(move.session);
    RenderInbox& to = devices_[move.to]->inbox();
    to.push(opened);
    if (codec != opened.grant.codec) to.push(CodecChosen{move.session, codec});
    devices_[move.from]->inbox().push(SessionLeaves{move.session, &to});
    tenants.push_back(opened.grant.tenant);
  }
  std::sort(tenants.begin(), tenants.end());
  tenants.erase(std::unique(tenants.begin(), tenants.end()), tenants.end());
  for (const TenantId tenant : tenants) tell_parts(tenant);
  if (!moves.empty())
    log::info("sessions moved", {{"from", moves.front().from}, {"to", moves.front().to}, {"count", moves.size()}});
}

// A tenant's limits hold for all devices together: each allows the part that its sessions ask of it.
void DevicePool::tell_parts(TenantId tenant) {
  if (devices_.size() == 1) return;
  for (uint32_t i = 0; i < devices_.size(); ++i)
    devices_[i]->inbox().push(TenantPart{tenant, placement_.part(i, tenant)});
}

}  // namespace gnomon::daemon
