#include "daemon/render/render_loop.h"

#include <algorithm>
#include <utility>

namespace gnomon::daemon {
namespace {

template <class... Reactions>
struct Reaction : Reactions... {
  using Reactions::operator()...;
};
template <class... Reactions>
Reaction(Reactions...) -> Reaction<Reactions...>;

}  // namespace

RenderLoop::RenderLoop(const SharingPolicy& sharing, RenderDevice& device, RenderInbox& inbox, Metrics& metrics,
                       FrameSink& sink)
    : device_(device),
      metrics_(metrics),
      motion_(device, metrics, sink),
      costs_(motion_, device.renderer().info().on_cpu),
      queue_(sharing, device.renderer().info().on_cpu ? kQuantumOfCpu : kQuantumOfGpu, costs_, sink, metrics),
      jobs_(device, inbox, metrics, sink, motion_, queue_),
      recovery_(device, motion_, metrics) {}

void RenderLoop::start(TimePoint now) {
  if (recovery_.lost()) recover(now);
  if (!recovery_.up()) return;
  for (const SceneId scene : motion_.step(now)) queue_.forget_costs(scene, now);
  queue_.release_held(now);
  if (!jobs_.look_for_room(now)) return;
  queue_.account().sample_backlog();
  device_.renderer().begin_batch();
  while (!recovery_.lost() && jobs_.look_for_room(now)) {
    queue_.drop_expired(now);
    const auto next = queue_.pick(now);
    if (!next) break;
    jobs_.submit(next->session, next->ticket, now);
  }
  device_.renderer().end_batch();
}

void RenderLoop::handle(RenderEvent event, TimePoint now) {
  const Reaction react{
      [&](const ViewRequest& view) { take_view(view, now); },
      [&](const CapacityRequested& asked) { answer_room(asked, now); },
      [&](const SessionOpened& opened) { queue_.open(opened); },
      [&](const SessionClosed& closed) { close(closed.session); },
      [&](const SessionMoved& leaves) { move_away(leaves); },
      [&](const OtherwiseServed& before) {
        // A client that was told of a smaller size or fewer samples would take no frame as large as it was granted.
        if (const RenderSession* session = queue_.find(before.session)) session->quality.tell_client();
      },
      [&](const LinkReviewed& reviewed) {
        if (RenderSession* session = queue_.find(reviewed.session)) session->quality.review_link(reviewed.window);
      },
      [&](const SceneLoaded& arrived) { bring_scene(arrived); },
      [&](const SceneUnloaded& leaves) { remove_scene(leaves.scene); },
      [&](const LightChanged& changed) { change_light(changed, now); },
      [&](const JobFinished& job) { settle_job(job, now); },
      [&](const SlotFreed&) { jobs_.load().slot_freed(); },
      [&](const BytesSent& sent) {
        queue_.account().sent(sent.tenant, sent.bytes, now);
        costs_.learn_bytes(sent);
      },
      [&](const SharingPolicyChanged& changed) { queue_.set_sharing(changed.sharing, now); },
      [&](const TenantDeviceShare& share) { queue_.account().set_fraction(share.tenant, share.fraction); },
      [&](const BackgroundDone&) {},  // start() takes over what was done
      [&](const StopRendering&) { stop(); },
  };
  std::visit(react, event);
}

TimePoint RenderLoop::wake_at() const { return std::min(jobs_.load().room_at(), queue_.held_until()); }

void RenderLoop::review_sessions(Nanoseconds since_last) {
  for (auto& [id, session] : queue_.sessions()) session.quality.review(since_last);
}

void RenderLoop::take_view(const ViewRequest& view, TimePoint now) {
  if (stopping_) return metrics_.report(view.tenant, view.session, Fault::view_draining);
  RenderSession* session = queue_.find(view.session);
  if (!session) return metrics_.report(view.tenant, view.session, Fault::session_gone);
  session->quality.view_arrived();
  session->coalesced += view.coalesced;
  if (session->newest) {
    ++session->coalesced;
    metrics_.coalesced(session->grant().tenant);
  }
  // After a move the previous device may pass on a view that is older than the newest one here.
  if (!session->newest || !is_newer(session->newest->frame, view.frame)) session->newest = view;
  if (session->partial) return;
  if (session->queued) {
    queue_.enqueue(*session, now);  // it keeps its place, with the deadline of its new view
  } else if (!session->held) {
    queue_.enqueue_when_allowed(*session, now);
  }
}

// Asks for the least size that the tenant allows: an applicant without room at that size may try another server, while
// an open session that runs out of memory later gets even smaller frames (MemorySteps).
void RenderLoop::answer_room(const CapacityRequested& asked, TimePoint now) {
  if (recovery_.lost() || stopping_) return asked.answer({});
  const double least = queue_.sharing().tenants[asked.tenant.value].degradation.least_size;
  gpu::RenderJob like;
  like.scene = asked.scene;
  like.width = shrunk(asked.width, least);
  like.height = shrunk(asked.height, least);
  like.samples = asked.samples;
  like.time = motion_.time_of(asked.scene, now);
  asked.answer(device_.renderer().make_room(like));
}

void RenderLoop::close(SessionId id) {
  RenderSession* session = queue_.find(id);
  if (!session) return;
  if (session->has_work()) metrics_.dropped(session->grant().tenant, id, Fault::session_gone);
  forget(*session);
}

// Frames of the session that are completely submitted are still sent; a partial frame is lost.
void RenderLoop::move_away(const SessionMoved& leaves) {
  RenderSession* session = queue_.find(leaves.session);
  if (!session) return;
  if (session->newest) leaves.to->push_view(*session->newest);
  if (!session->quality.is_as_granted()) leaves.to->push(OtherwiseServed{leaves.session});
  forget(*session);
}

void RenderLoop::forget(RenderSession& session) {
  if (session.partial) jobs_.give_up(session);
  queue_.close(session.opened.session);
}

void RenderLoop::bring_scene(const SceneLoaded& arrived) {
  if (stopping_) return arrived.resident(Error{"the server is stopping"});
  if (recovery_.lost()) return recovery_.defer(arrived);
  device_.bring_scene(arrived.scene, arrived.owner, [this, arrived](Result<gpu::SceneFootprint> made) {
    if (!made) return arrived.resident(std::move(made));
    motion_.add(arrived.scene.id, arrived.name, arrived.scene);
    const auto resident = [resident = arrived.resident, made] { resident(made); };
    arrived.lights ? motion_.show(arrived.scene.id, arrived.lights(), resident) : resident();
  });
}

void RenderLoop::remove_scene(SceneId scene) {
  recovery_.forget(scene);
  device_.remove_scene(scene);
  motion_.remove(scene);
}

void RenderLoop::change_light(const LightChanged& changed, TimePoint now) {
  if (recovery_.lost()) return recovery_.defer(changed);
  motion_.change(changed.scene, changed.light, changed.change, now, changed.version);
}

void RenderLoop::settle_job(const JobFinished& job, TimePoint now) {
  jobs_.load().job_finished(job.booked, now);
  queue_.charge(job.ticket, job.policy, job.gpu, now);
  queue_.account().finished(job.ticket.tenant, job.ticket.predicted, job.gpu, now);
  metrics_.device_busy(device_.number(), job.ticket.tenant, job.gpu);
  if (job.device_lost) {
    metrics_.dropped(job.ticket.tenant, job.ticket.session, Fault::device_lost);
    return lose_device();
  }
  if (job.out_of_memory) return settle_unstarted(job, now);
  RenderSession* session = queue_.find(job.ticket.session);
  if (session) session->view.learn(job.model_cost, {job.gpu - job.trace, job.trace});
  if (costs_.learn(job, queue_.quantum())) queue_.requeue_scene(job.scene, now);
}

// A band that was not started loses its frame. If the frame was given up before, it was counted then.
void RenderLoop::settle_unstarted(const JobFinished& job, TimePoint now) {
  RenderSession* session = queue_.find(job.ticket.session);
  const bool partial = session && session->partial && session->partial->job == job.job;
  if (!partial && !job.last) return;
  metrics_.dropped(job.ticket.tenant, job.ticket.session, Fault::submit_failed, "no memory to start it");
  if (!partial) return;
  jobs_.give_up(*session);
  if (session->newest && !session->held) queue_.enqueue_when_allowed(*session, now);
}

// Partial frames are lost with the device; sessions with a newer view enter the queue again.
void RenderLoop::lose_device() {
  recovery_.lose();
  motion_.answer_waiting();
  for (auto& [id, session] : queue_.sessions()) {
    if (!session.partial) continue;
    jobs_.give_up(session);
    if (session.newest && !session.held) queue_.enqueue_when_allowed(session, TimePoint::max());
  }
}

void RenderLoop::recover(TimePoint now) {
  if (!jobs_.load().idle() || stopping_ || failure()) return;
  for (RenderEvent& event : recovery_.recover(now)) handle(std::move(event), now);
}

void RenderLoop::stop() {
  stopping_ = true;
  recovery_.refuse_waiting(Error{"the server is stopping"});
  motion_.answer_waiting();
  while (!queue_.sessions().empty()) {
    RenderSession& session = queue_.sessions().begin()->second;
    if (session.has_work()) metrics_.dropped(session.grant().tenant, session.opened.session, Fault::view_draining);
    forget(session);
  }
}

}  // namespace gnomon::daemon
