// What the render loop knows of one session: its newest view, the frame that was begun, and what the next piece of
// work is.
#pragma once

#include <optional>

#include "daemon/render/session_quality.h"
#include "scheduler/cost_model.h"

namespace gnomon::daemon {

// A frame of which not all rows were submitted.
struct PartialFrame {
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
  RenderSession(SessionOpened as_opened, FrameSink& sink, Metrics& metrics)
      : opened(std::move(as_opened)), quality(opened, sink, metrics), codec(opened.grant.codec) {}
  RenderSession(const RenderSession&) = delete;
  RenderSession& operator=(const RenderSession&) = delete;

  const SessionOpened opened;
  SessionQuality quality;
  protocol::CodecId codec;  // in force where the link is not short of bytes
  std::optional<ViewRequest> newest;
  uint32_t coalesced = 0;  // views replaced since its last frame
  std::optional<PartialFrame> partial;
  bool queued = false;  // stands in the scheduler's queue with `next`
  bool held = false;    // waits until its tenant's or its own rate lets it into the queue
  NextJob next;
  scheduler::ViewFactor view;

  const SessionGrant& grant() const { return opened.grant; }
  bool has_work() const { return partial || newest; }
};

// Pieces cost at most this part of a quantum, uncut frames half of one: a newcomer waits for the rest of the job on the
// device and for one that is before it by its virtual deadline, and together they are no more than a quantum.
inline constexpr int kJobsOfAQuantum = 3;

// Cuts what remains of a frame so that no piece costs more than that, as far as whole rows and the rasterising allow:
// that is done in one go, alone if it must be. `quantum` 0: there are no cuts.
NextJob next_job(const RenderSession& session, const scheduler::CostModel& model, Nanoseconds quantum);

}  // namespace gnomon::daemon
