#include "daemon/render/device_pool.h"

#include <algorithm>

#include "daemon/render/ask_all.h"

namespace gnomon::daemon {
namespace {

// Adds another device's figures of the same tenant.
void add(TenantReport& sum, const TenantReport& more) {
  sum.service += more.service;
  sum.share += more.share;
  sum.expected_share += more.expected_share;
  sum.lag += more.lag;
  sum.predicted_error = std::max(sum.predicted_error, more.predicted_error);
}

bool any_up(const std::vector<std::unique_ptr<DeviceThread>>& devices) {
  return std::any_of(devices.begin(), devices.end(), [](const auto& device) { return device->up(); });
}

}  // namespace

DevicePool::DevicePool(size_t count, double assumed_rate_hz, Metrics& metrics, Health& health)
    : metrics_(metrics),
      health_(health),
      devices_([&] {
        std::vector<std::unique_ptr<DeviceThread>> devices;
        for (uint32_t i = 0; i < count; ++i)
          devices.push_back(std::make_unique<DeviceThread>(i, metrics, static_cast<Owner&>(*this)));
        return devices;
      }()),
      places_(devices_, assumed_rate_hz) {}

Result<void> DevicePool::start(const std::vector<RendererFactory>& factories, const SharingPolicy& sharing,
                               const SceneMotion::Settings& motion, FrameSink& sink,
                               std::function<void(const Error&)> failed) {
  failed_ = std::move(failed);
  for (uint32_t i = 0; i < devices_.size(); ++i) {
    if (auto started = devices_[i]->start(factories[i], sharing, motion, sink); !started) return started;
    metrics_.devices().up(i, true);
  }
  health_.device_up = true;
  return {};
}

void DevicePool::stop() {
  for (const auto& device : devices_) device->inbox().push(StopRendering{});
  for (const auto& device : devices_) device->stop();
}

std::vector<PooledDevice> DevicePool::report() const {
  const CostModels known = costs();
  std::lock_guard lock(mutex_);
  const std::vector<double> loads = places_.loads(known);
  std::vector<PooledDevice> all;
  for (uint32_t i = 0; i < devices_.size(); ++i)
    all.push_back({devices_[i]->info(), devices_[i]->up(), places_.drained(i), places_.sessions(i), loads[i]});
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

// For each scene, the model of the first device in order that has one.
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
    const auto published = device->scenes();  // kept, as the device may publish others meanwhile
    for (const auto& [id, scene] : *published) {
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

bool DevicePool::push_view(const ViewRequest& view) {
  if (devices_.size() == 1) return devices_.front()->inbox().push_view(view);
  std::lock_guard lock(mutex_);
  return places_.inbox_of(view.session).push_view(view);
}

void DevicePool::ask_room(const CapacityRequested& asked) {
  std::vector<RenderInbox*> inboxes;
  {
    std::lock_guard lock(mutex_);
    inboxes = places_.open_inboxes();
  }
  if (inboxes.empty()) return asked.answer({});
  ask_all(inboxes, AnswerAt::first_success, asked.answer, [&](const auto& reply) {
    CapacityRequested question = asked;
    question.answer = reply;
    return question;
  });
}

void DevicePool::open(const SessionOpened& session) {
  std::lock_guard lock(mutex_);
  places_.open(session);
}

void DevicePool::close(SessionId session) {
  std::lock_guard lock(mutex_);
  places_.close(session);
}

void DevicePool::review(const LinkReviewed& reviewed) {
  std::lock_guard lock(mutex_);
  places_.inbox_of(reviewed.session).push(reviewed);
}

void DevicePool::sent(uint32_t device, const BytesSent& sent) { devices_[device]->inbox().push(sent); }

void DevicePool::set_sharing(const SharingPolicy& sharing) {
  for (const auto& device : devices_) device->inbox().push(SharingPolicyChanged{sharing});
}

// Every device gets all changes in the same order, so that the versions they count are the same.
void DevicePool::change_light(const LightChanged& change) {
  std::lock_guard lock(mutex_);
  for (const auto& device : devices_) device->inbox().push(change);
}

void DevicePool::bring(const SceneLoaded& arrived) {
  std::vector<RenderInbox*> inboxes;
  for (const auto& device : devices_) inboxes.push_back(&device->inbox());
  ask_all(inboxes, AnswerAt::last, arrived.resident, [&](const auto& reply) {
    return SceneLoaded{arrived.scene, reply, arrived.name, arrived.lights, arrived.owner};
  });
}

void DevicePool::take_away(SceneId scene) {
  for (const auto& device : devices_) device->inbox().push(SceneUnloaded{scene});
}

DevicePool::DrainAnswer DevicePool::set_drained(size_t device, bool drained) {
  if (device >= devices_.size()) return DrainAnswer::no_such_device;
  std::lock_guard lock(mutex_);
  const auto number = static_cast<uint32_t>(device);
  if (drained && !places_.drained(number) && !places_.any_other_open(number)) return DrainAnswer::last_in_service;
  log::info(drained ? "device drained" : "device takes sessions again", {{"number", device}});
  places_.set_drained(number, drained);
  return DrainAnswer::done;
}

void DevicePool::device_changed(uint32_t device, bool up) {
  std::lock_guard lock(mutex_);
  places_.set_down(device, !up);
  metrics_.devices().up(device, up);
  health_.device_up = any_up(devices_);
}

void DevicePool::device_failed(uint32_t device, const Error& why) {
  std::lock_guard lock(mutex_);
  places_.set_gone(device);
  const bool others = any_up(devices_);
  health_.device_up = others;
  if (others) return log::error("a device is beyond repair", {{"number", device}, {"why", why.message}});
  failed_(why);
}

// Called once a second by each device's thread: the combined figures of all devices go to the metrics.
void DevicePool::device_reported() {
  metrics_.shares(shares());
  for (const auto& [id, scene] : scenes()) metrics_.scenes().built(scene);
  const std::vector<PooledDevice> devices = report();
  for (uint32_t i = 0; i < devices.size(); ++i) {
    metrics_.devices().sessions(i, devices[i].sessions);
    metrics_.devices().load(i, devices[i].load);
  }
}

}  // namespace gnomon::daemon
