// The render loop's state of one session: its newest view, its partial frame, and its next job.
#pragma once

#include <optional>

#include "daemon/render/session_quality.h"
#include "scheduler/cost_model.h"

namespace gnomon::daemon {

// A frame of which not all tile rows are submitted.
struct PartialFrame {
  JobId job;
  FrameMeta meta;
  uint32_t next_row = 0;
  bool unbuilt = false;  // the scene's lights are traced with a hierarchy (gpu::LightState)
};

// The next job of a session: a complete frame, or some rows of tiles.
struct NextJob {
  TileRows rows;
  scheduler::Work work;
  scheduler::Cost model_cost{};  // prediction of the scene's model; 0 if it knows nothing yet
  Nanoseconds cost{};            // prediction for this session's view
  // With what it counts while it is on the device: the prediction, and at least a quarter of what it may cost at worst,
  // so that few jobs are under way whose view may be dearer than any of late.
  Nanoseconds booked{};
};

struct RenderSession {
  RenderSession(SessionOpened as_opened, FrameSink& sink, Metrics& metrics)
      : opened(std::move(as_opened)), quality(opened, sink, metrics) {}
  RenderSession(const RenderSession&) = delete;
  RenderSession& operator=(const RenderSession&) = delete;

  const SessionOpened opened;
  SessionQuality quality;
  std::optional<ViewRequest> newest;
  uint32_t coalesced = 0;  // views replaced since its last frame
  std::optional<PartialFrame> partial;
  bool queued = false;  // in the scheduler's queue, with `next`
  bool held = false;    // waits until its own and its tenant's rate allow it to enter the queue
  NextJob next;
  scheduler::ViewFactor view;

  const SessionGrant& grant() const { return opened.grant; }
  bool has_work() const { return partial || newest; }
};

// A piece costs at most a third of a quantum, an uncut frame half of one: a newcomer waits for the rest of the job on
// the device and for one job that precedes it by its virtual deadline, and both together cost at most a quantum.
inline constexpr int kJobsOfAQuantum = 3;

// Cuts what remains of a frame so that no piece costs more than that, as far as complete rows and the rasterisation
// allow; the latter is never cut, and makes up a piece alone if it has to. `quantum` 0: frames are never cut.
// `most_bits`: what may take a quantum at worst, and so at most makes up a job.
NextJob next_job(const RenderSession& session, const scheduler::CostModel& model, Nanoseconds quantum,
                 uint64_t most_bits);

}  // namespace gnomon::daemon
