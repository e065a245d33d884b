// Everything that the render thread reacts to, in one inbox.
#pragma once

#include <atomic>
#include <functional>
#include <utility>
#include <variant>

#include "common/inbox.h"
#include "daemon/config/terms.h"
#include "daemon/frame/frame.h"
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
  uint32_t life = 0;                          // how often it was resumed
};

// A session of such frames is about to be opened: is there memory for them, at the least size that its tenant allows?
struct RoomAsked {
  SceneId scene;  // resident
  TenantId tenant;
  uint32_t width = 0, height = 0;            // granted
  std::function<void(Result<void>)> answer;  // called on the render thread
};

// The session's frames are coded so from the next one on.
struct CodecChosen {
  SessionId session;
  protocol::CodecId codec = protocol::CodecId::tiles_lz4;
};

struct SessionClosed {
  SessionId session;
};

class RenderInbox;

// The session lives on another device from now on; `to` has been told of it.
struct SessionLeaves {
  SessionId session;
  RenderInbox* to = nullptr;  // of that device: gets the view that waits
};

// Of what a tenant may use on all devices together, what it may use of this one: 0 to 1.
struct TenantPart {
  TenantId tenant;
  double part = 1;
};

struct SceneArrived {
  scenes::LoadedScene scene;
  std::function<void(Result<gpu::SceneFootprint>)> resident;  // called on the render thread
  std::string name = {};
};

// No session uses it, nor will before it is brought again.
struct SceneLeaves {
  SceneId scene;
};

struct LightChanged {
  SceneId scene;
  uint32_t light = 0;
  LightChange change;
};

struct BackgroundDone {};  // the renderer has finished something beside the frames

// A submit is done: a frame or a band of one.
struct JobFinished {
  JobId job;
  bool last = true;  // of its frame's bands
  scheduler::Ticket ticket;
  uint64_t policy = 0;  // number of the policy that gave the ticket out
  SceneId scene;
  scheduler::Work work;
  scheduler::Cost model_cost{};  // 0: a guess of a model that knew nothing
  Nanoseconds gpu{};
  Nanoseconds trace{};   // of it, the part that grows with the bits
  bool unbuilt = false;  // a hierarchy answered for the lights of its scene
  bool device_lost = false;
  bool out_of_memory = false;  // it was not started
};

// How a session's link did lately.
struct LinkReviewed {
  SessionId session;
  LinkWindow window;
};

// A frame has left; its tenant may have a limit of bytes.
struct BytesSent {
  TenantId tenant;
  SceneId scene;
  uint64_t bits = 0;
  size_t bytes = 0;
};

struct LeaseDropped {};  // a frame slot may be free again

// The device is shared on other terms from now on. Tenants are never fewer than before.
struct TermsChanged {
  Terms terms;
};

struct StopRendering {};  // no further views; the loop ends when the last lease has come back

using RenderEvent = std::variant<ViewRequest, RoomAsked, SessionOpened, CodecChosen, SessionClosed, SessionLeaves,
                                 SceneArrived, SceneLeaves, JobFinished, LeaseDropped, BytesSent, LightChanged,
                                 BackgroundDone, LinkReviewed, TermsChanged, TenantPart, StopRendering>;

// Only views come as fast as strangers please: their number is bounded, everything else passes.
class RenderInbox {
 public:
  explicit RenderInbox(size_t max_views = 16384) : max_views_(max_views) {}

  bool push(RenderEvent event) { return events_.push(std::move(event)); }

  // False: too many are waiting (the render thread is busy with a scene), or closed. The view is dropped.
  bool push_view(const ViewRequest& view) {
    if (views_.fetch_add(1, std::memory_order_relaxed) < max_views_ && events_.push(view)) return true;
    views_.fetch_sub(1, std::memory_order_relaxed);
    return false;
  }

  // The render thread.
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
