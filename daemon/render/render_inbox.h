// The events that the render thread reacts to, and the inbox that collects them.
#pragma once

#include <atomic>
#include <functional>
#include <utility>
#include <variant>

#include "common/inbox.h"
#include "daemon/config/sharing_policy.h"
#include "daemon/frame/frame.h"
#include "daemon/frame/frame_sink.h"
#include "daemon/frame/grant.h"
#include "daemon/link/link_window.h"
#include "daemon/render/light_change.h"
#include "daemon/render/link_steps.h"
#include "scenes/registry.h"
#include "scheduler/cost_model.h"
#include "scheduler/scheduler.h"

namespace gnomon::daemon {

// The grant's scene is resident.
struct SessionOpened {
  SessionId session{};
  SessionGrant grant = {};
  uint32_t net_thread = 0;                    // index of the net thread that owns the session
  SessionReferencesPtr references = nullptr;  // null if the client keeps no frames
  uint32_t generation = 0;                    // how often it was resumed
};

// Asks whether there is memory for the frames of a session that is about to be opened, at the least size that its
// tenant allows.
struct CapacityRequested {
  SceneId scene;  // resident
  TenantId tenant;
  uint32_t width = 0, height = 0;            // granted
  SampleCounts samples = {};                 // granted
  std::function<void(Result<void>)> answer;  // called on the render thread
};

struct SessionClosed {
  SessionId session;
};

class RenderInbox;

// The session moves to another device, whose inbox already has its SessionOpened.
struct SessionMoved {
  SessionId session;
  RenderInbox* to = nullptr;  // of the other device; receives the view that waits
};

// Of a session that has moved here: its client was told last, by the device before, of less than it was granted.
struct OtherwiseServed {
  SessionId session;
};

// The share of a tenant's limits, which hold for all devices together, that applies to this device: 0 to 1.
struct TenantDeviceShare {
  TenantId tenant;
  double fraction = 1;
};

struct SceneLoaded {
  scenes::LoadedScene scene;
  std::function<void(Result<gpu::SceneFootprint>)> resident;  // called on the render thread
  std::string name = {};
  // What operators have changed until the scene is there, called on the render thread then; if empty, nothing.
  std::function<LightsUpdate()> lights = {};
  gpu::SceneOwner owner = {};
};

// The scene is removed from the device. No session uses it, nor will before it is brought again.
struct SceneUnloaded {
  SceneId scene;
};

struct LightChanged {
  SceneId scene;
  uint32_t light = 0;
  LightChange change;
  uint32_t version = 0;  // of the scene's lights with it, from 1
};

struct BackgroundDone {};  // the renderer has finished something in the background

// A submit is finished: a frame or a band of one.
struct JobFinished {
  JobId job;
  bool last = true;  // the last band of its frame
  scheduler::Ticket ticket;
  uint64_t policy = 0;  // number of the policy that issued the ticket
  SceneId scene;
  SampleCounts samples = {};
  scheduler::Work work;
  scheduler::Cost model_cost{};  // predicted; 0 if the model knew nothing yet
  Nanoseconds booked{};          // NextJob::booked
  Nanoseconds gpu{};             // device time
  Nanoseconds trace{};           // the part of `gpu` that grows with the traced bits
  bool unbuilt = false;          // the scene's lights were traced with a hierarchy (gpu::LightState)
  bool device_lost = false;
  bool out_of_memory = false;  // the job was not started
};

// The views of a session's link since the last review.
struct LinkReviewed {
  SessionId session;
  LinkWindow window;
};

// A frame was sent; its bytes count against the tenant's limit.
struct BytesSent {
  TenantId tenant;
  SceneId scene;
  uint64_t bits = 0;
  size_t bytes = 0;
  SampleCounts samples = {};
};

struct SlotFreed {};  // that of a frame whose lease was dropped, or that was abandoned and has left the device

// The device is shared by this policy from now on. There are at least as many tenants as before.
struct SharingPolicyChanged {
  SharingPolicy sharing;
};

struct StopRendering {};  // no further views are taken; the loop ends when the last lease is dropped

using RenderEvent =
    std::variant<ViewRequest, CapacityRequested, SessionOpened, SessionClosed, SessionMoved, OtherwiseServed,
                 SceneLoaded, SceneUnloaded, JobFinished, SlotFreed, BytesSent, LightChanged, BackgroundDone,
                 LinkReviewed, SharingPolicyChanged, TenantDeviceShare, StopRendering>;

// Any thread pushes, the render thread takes. The number of views is bounded, as clients decide how fast they come;
// other events are not limited.
class RenderInbox {
 public:
  explicit RenderInbox(size_t max_views = 16384) : max_views_(max_views) {}

  // Nothing but views may be lost for want of memory, a job's end least of all.
  bool push(RenderEvent event) { return events_.push_surely(std::move(event)); }

  // Returns false, and drops the view, if too many views wait or the inbox is closed.
  bool push_view(const ViewRequest& view) {
    if (views_.fetch_add(1, std::memory_order_relaxed) < max_views_ && events_.push(view)) return true;
    views_.fetch_sub(1, std::memory_order_relaxed);
    return false;
  }

  // The render thread: replaces `batch` with all events, and waits for the first one until `deadline`.
  void take(std::vector<RenderEvent>& batch, TimePoint deadline) {
    events_.take(batch, deadline);
    size_t views = 0;
    for (const RenderEvent& event : batch) views += std::holds_alternative<ViewRequest>(event);
    views_.fetch_sub(views, std::memory_order_relaxed);
  }

  void close() { events_.close(); }

 private:
  const size_t max_views_;
  std::atomic<size_t> views_{0};
  Inbox<RenderEvent> events_;
};

}  // namespace gnomon::daemon
