// What the render loop knows of one session: its newest view, the frame that was begun, and what the next piece of
// work is.
#pragma once

#include <optional>

#include "daemon/render/link_steps.h"
#include "daemon/render/memory_steps.h"
#include "daemon/render/render_inbox.h"
#include "scheduler/cost_model.h"
#include "scheduler/degradation.h"
#include "scheduler/rate_limit.h"

namespace gnomon::daemon {

// A frame of which not all rows were submitted.
struct BegunFrame {
  JobId job;
  FrameMeta meta;
  uint32_t next_row = 0;
  bool unbuilt = false;  // a hierarchy answers for the lights of its scene
};

// The next job of a session: a whole frame, or some rows of tiles.
struct NextJob {
  TileRows rows;
  scheduler::Work work;
  scheduler::Cost model_cost{};  // what the model says; 0: it knows nothing yet
  Nanoseconds cost{};            // what it says for this session's view
};

struct RenderSession {
  explicit RenderSession(SessionOpened as_opened)
      : opened(std::move(as_opened)),
        width(opened.grant.width),
        height(opened.grant.height),
        codec(opened.grant.codec) {}

  const SessionOpened opened;
  uint32_t width, height;   // of its frames, in force
  protocol::CodecId codec;  // in force where the link is not short of bytes
  std::optional<ViewRequest> newest;
  uint32_t coalesced = 0;  // views replaced since its last frame
  std::optional<BegunFrame> begun;
  bool asked = false;  // stands in the scheduler's queue with `next`
  bool held = false;   // waits until its tenant's or its own rate lets it ask
  NextJob next;
  scheduler::ViewFactor view;
  scheduler::RateLimit rate;  // in force
  scheduler::Degradation degradation;
  gpu::LightSet untraced;
  LinkSteps link;
  MemorySteps memory;
  uint32_t arrived = 0, answered = 0;  // views since the last review

  const SessionGrant& grant() const { return opened.grant; }

  // In force now, and where the degradation wants it.
  double rate_hz() const { return grant().rate_hz * degradation.point().rate; }
  TileGrid wanted_grid() const;
  uint32_t wanted_lights() const;  // that are traced; at least one
  uint32_t traced_lights() const { return grant().lights - static_cast<uint32_t>(untraced.count()); }
  TileGrid grid() const { return {width, height, grant().lights}; }
  bool has_granted_size() const { return width == grant().width && height == grant().height; }
  bool has_work() const { return begun || newest; }
};

// That share of a side, in whole tiles where it is not all of it.
uint32_t shrunk(uint32_t side, double share);

// Pieces cost at most this part of a slice, uncut frames half of one: a newcomer waits for the rest of the job on the
// device and for one that is before it by its virtual deadline, and together they are no more than a slice.
inline constexpr int kJobsOfASlice = 3;

// Cuts what remains of a frame so that no piece costs more than that, as far as whole rows and the rasterising allow:
// that is done in one go, alone if it must be. slice 0: no cuts.
NextJob next_job(const RenderSession& session, const scheduler::CostModel& model, Nanoseconds slice);

}  // namespace gnomon::daemon
