#include "daemon/render/frame_jobs.h"

#include <utility>

#include "common/within_memory.h"
#include "gpu/wire/translate.h"

namespace gnomon::daemon {
namespace {

FrameMeta meta_of(const RenderSession& session, const ViewRequest& view, uint32_t device, TimePoint now) {
  const SessionQuality& quality = session.quality;
  return {.route = {.session = view.session,
                    .tenant = session.grant().tenant,
                    .scene = session.grant().scene,
                    .net_thread = session.opened.net_thread,
                    .device = device,
                    .frame = view.frame},
          .spec = {.codec = quality.wants_dense_codec() ? session.grant().dense_codec : session.grant().codec,
                   .slice_body_bytes = view.slice_body_bytes,
                   .references = session.opened.references,
                   .camera = view.camera,
                   .grid = quality.grid(),
                   .tells_size = session.grant().has(protocol::kFeatureSizes) && !quality.has_granted_size(),
                   .samples = quality.samples(),
                   .tells_samples = session.grant().has(protocol::kFeatureSoft) && !quality.has_granted_samples(),
                   .traced_bits = quality.traced_bits(uint64_t{quality.grid().width} * quality.grid().height)},
          .times = {.arrival = view.arrival, .deadline = view.deadline, .submitted = now},
          .coalesced = session.coalesced};
}

}  // namespace

bool FrameJobs::look_for_room(TimePoint now) {
  const gpu::Renderer& renderer = device_.renderer();
  return load_.look_for_room(renderer.free_slots(), queue_.sharing().frames_in_flight, renderer.overlapping(),
                             queue_.quantum(), now);
}

void FrameJobs::submit(RenderSession& session, const scheduler::Ticket& ticket, TimePoint now) {
  if (session.partial) return resume(session, ticket, now);
  // Other sessions may have used up the tenant's rate.
  if (queue_.account().eligible_at(session.grant().tenant) > now) {
    queue_.refund(ticket, now);
    return queue_.enqueue_when_allowed(session, now);
  }
  begin(session, ticket, now);
}

void FrameJobs::begin(RenderSession& session, const scheduler::Ticket& ticket, TimePoint now) {
  const ViewRequest view = *std::exchange(session.newest, std::nullopt);
  const SceneId scene = session.grant().scene;
  const glm::vec3 eye = gpu::from_wire(view.camera).position;
  if (session.quality.adapt(motion_.lights_of(scene), eye, now)) queue_.cut_next_job(session);
  // A frame that is rendered in bands holds its slot for long, so the last free slot is left to uncut frames.
  const bool cut = session.next.rows.count < session.quality.grid().tiles_y();
  if (cut && device_.renderer().free_slots() < 2) queue_.cut_next_job(session, Nanoseconds{});
  PartialFrame frame{JobId{next_job_++}, meta_of(session, view, device_.number(), now), 0, motion_.unbuilt(scene)};
  if (session.grant().has(protocol::kFeatureMoments)) frame.meta.spec.moment = motion_.moment_of(scene, now);
  const auto begun = device_.renderer().submit(job_of(session, frame, now), completion(session, ticket, frame));
  if (!begun) {
    if (!session.quality.shrink(now, begun.error())) return not_submitted(session, ticket, begun.error(), now);
    queue_.refund(ticket, now);
    session.newest = view;  // to be tried again at a smaller size
    return queue_.enqueue_when_allowed(session, now);
  }
  session.coalesced = 0;
  session.quality.frame_begun(now);
  load_.frame_begun();
  session.partial = std::move(frame);
  submitted(session, now);
}

gpu::RenderJob FrameJobs::job_of(const RenderSession& session, const PartialFrame& frame, TimePoint now) const {
  const TileGrid grid = session.quality.grid();
  gpu::RenderJob job;
  job.id = frame.job;
  job.scene = session.grant().scene;
  job.camera = gpu::from_wire(frame.meta.spec.camera);
  job.width = grid.width;
  job.height = grid.height;
  job.time = motion_.time_of(job.scene, now);
  job.untraced = session.quality.untraced();
  job.samples = session.quality.samples();
  if (session.next.rows.count < grid.tiles_y()) job.tile_rows = session.next.rows.count;
  return job;
}

void FrameJobs::resume(RenderSession& session, const scheduler::Ticket& ticket, TimePoint now) {
  const PartialFrame& frame = *session.partial;
  const auto resumed =
      device_.renderer().resume(frame.job, session.next.rows.count, completion(session, ticket, frame));
  if (resumed) return submitted(session, now);
  give_up(session);
  not_submitted(session, ticket, resumed.error(), now);
}

void FrameJobs::submitted(RenderSession& session, TimePoint now) {
  load_.job_started(session.next.booked, now);
  const scheduler::Work& work = session.next.work;
  queue_.account().started(session.grant().tenant, work.begins, work.bits, now);
  session.partial->next_row += session.next.rows.count;
  if (session.partial->next_row < session.quality.grid().tiles_y()) return queue_.enqueue(session, now);
  session.partial.reset();
  load_.frame_submitted();
  if (session.newest) queue_.enqueue_when_allowed(session, now);
}

void FrameJobs::not_submitted(RenderSession& session, const scheduler::Ticket& ticket, const Error& why,
                              TimePoint now) {
  queue_.refund(ticket, now);
  metrics_.dropped(ticket.tenant, ticket.session, Fault::submit_failed, why.message);
  if (session.newest) queue_.enqueue_when_allowed(session, now);
}

void FrameJobs::give_up(RenderSession& session) {
  device_.renderer().abandon(session.partial->job);
  session.partial.reset();
  load_.frame_abandoned();
  queue_.withdraw(session);
}

// The returned function runs on the completion thread: it passes the mask on to be encoded and reports the job's cost to
// the inbox.
std::function<void(gpu::FrameDone)> FrameJobs::completion(const RenderSession& session,
                                                          const scheduler::Ticket& ticket,
                                                          const PartialFrame& frame) const {
  JobFinished job;
  job.job = frame.job;
  job.ticket = ticket;
  job.policy = queue_.policy();
  job.scene = session.grant().scene;
  job.samples = session.quality.samples();
  job.work = session.next.work;
  job.model_cost = session.next.model_cost;
  job.booked = session.next.booked;
  job.unbuilt = frame.unbuilt;
  return [job, meta = frame.meta, &inbox = inbox_, &sink = sink_](gpu::FrameDone done) mutable {
    job.gpu = Nanoseconds(done.gpu_ns);
    job.trace = Nanoseconds(done.trace_ns);
    job.device_lost = done.device_lost;
    job.out_of_memory = done.out_of_memory;
    job.last = done.complete;
    if (done.complete && !done.device_lost && !done.out_of_memory) {
      meta.times.rendered = done.completed_at;
      meta.times.gpu = Nanoseconds(done.frame_gpu_ns);
      meta.times.readback = Nanoseconds(done.readback_ns);
      done_or_dropped("a rendered frame", [&] { sink.on_rendered({std::move(meta), std::move(done.mask)}); });
    }
    // Last: when every job is reported the render thread may end, and the sink with it.
    inbox.push(job);
  };
}

}  // namespace gnomon::daemon
