#include "daemon/render_loop.h"

#include <utility>

namespace gnomon::daemon {
namespace {

// A renderer that refuses this many submits in a row is treated as lost: it may have been lost between frames.
constexpr uint32_t kFailedSubmitsAreALoss = 8;

}  // namespace

RenderLoop::RenderLoop(std::unique_ptr<scheduler::Scheduler> scheduler, RenderDevice& device, RenderInbox& inbox,
                       Metrics& metrics, std::function<void(RenderedFrame)> rendered)
    : scheduler_(std::move(scheduler)),
      device_(device),
      inbox_(inbox),
      metrics_(metrics),
      rendered_(std::move(rendered)) {}

void RenderLoop::start(TimePoint now) {
  if (lost_ && in_flight_ == 0 && !stopping_ && !failure_) recover(now);
  if (lost_ || failure_) return;
  device_.renderer().begin_batch();
  while (!lost_ && device_.renderer().free_slots() > 0) {
    const auto picked = scheduler_->pick(now);
    if (!picked) break;
    submit(sessions_.at(picked->session), *picked, now);
  }
  device_.renderer().end_batch();
}

void RenderLoop::handle(RenderEvent event, TimePoint now) {
  std::visit([&](const auto& e) { on(e, now); }, event);
}

void RenderLoop::on(const ViewRequest& view, TimePoint now) {
  if (stopping_) return metrics_.report(Fault::view_draining);
  const auto found = sessions_.find(view.session);
  if (found == sessions_.end()) return metrics_.report(Fault::session_gone);
  Session& session = found->second;
  if (session.newest) {
    ++session.coalesced;
    metrics_.coalesced(session.opened.tenant);
  }
  session.newest = view;
  scheduler_->make_ready(view.session, {session.cost}, now);
}

void RenderLoop::on(const SessionOpened& opened, TimePoint) {
  sessions_.emplace(opened.session, Session{opened, std::nullopt});
  scheduler_->add_session(opened.session, opened.tenant);
}

void RenderLoop::on(const SessionClosed& closed, TimePoint) {
  const auto found = sessions_.find(closed.session);
  if (found == sessions_.end()) return;
  if (found->second.newest) metrics_.report(Fault::session_gone);
  scheduler_->remove_session(closed.session);
  sessions_.erase(found);
}

void RenderLoop::on(const SceneArrived& arrived, TimePoint) {
  if (lost_) return arrived.resident(Error{"the device is being made anew"});
  arrived.resident(device_.add_scene(arrived.scene));
}

void RenderLoop::on(const FrameFinished& finished, TimePoint now) {
  scheduler_->charge(finished.ticket, finished.gpu, now);
  const auto found = sessions_.find(finished.ticket.session);
  if (found != sessions_.end() && !finished.device_lost) found->second.cost = finished.gpu;
  metrics_.device_busy(finished.gpu);
  if (!finished.device_lost) return;
  metrics_.report(Fault::device_lost, {{"session", finished.ticket.session.value}});
  lost_ = true;
}

void RenderLoop::on(const LeaseDropped&, TimePoint) { --in_flight_; }

void RenderLoop::on(const StopRendering&, TimePoint) {
  stopping_ = true;
  for (auto& [id, session] : sessions_) {
    if (session.newest) metrics_.report(Fault::view_draining);
    scheduler_->remove_session(id);
  }
  sessions_.clear();
}

void RenderLoop::submit(Session& session, const scheduler::Ticket& ticket, TimePoint now) {
  const ViewRequest view = *std::exchange(session.newest, std::nullopt);
  const SessionOpened& opened = session.opened;
  FrameMeta meta;
  meta.session = view.session;
  meta.net_thread = opened.net_thread;
  meta.frame = view.frame;
  meta.codec = opened.codec;
  meta.grid = {opened.width, opened.height, opened.lights};
  meta.coalesced = std::exchange(session.coalesced, 0);
  meta.arrival = view.arrival;
  meta.submitted = now;

  const gpu::RenderJob job{JobId{next_job_++}, opened.scene, view.camera, opened.width, opened.height};
  const auto submitted = device_.renderer().submit(job, completion(meta, ticket));
  if (submitted) {
    ++in_flight_;
    failed_submits_ = 0;
    return;
  }
  scheduler_->charge(ticket, Nanoseconds{}, now);
  metrics_.report(Fault::submit_failed, {{"session", view.session.value}, {"why", submitted.error().message}});
  if (++failed_submits_ >= kFailedSubmitsAreALoss) lost_ = true;
}

// Runs on the completion thread: the mask goes on to be encoded, the news comes back here. However the lease ends,
// encoded or thrown away, its end is an event of ours: it is what makes a slot free.
std::function<void(gpu::FrameDone)> RenderLoop::completion(const FrameMeta& meta, const scheduler::Ticket& ticket) {
  return [meta, ticket, &inbox = inbox_, &rendered = rendered_](gpu::FrameDone done) {
    inbox.push(FrameFinished{ticket, Nanoseconds(done.gpu_ns), done.device_lost});
    auto slot = std::make_shared<gpu::FrameLease>(std::move(done.mask));
    const TileMaskView mask = slot->mask();
    gpu::FrameLease lease(mask, [slot = std::move(slot), &inbox] {
      slot->drop();
      inbox.push(LeaseDropped{});
    });
    if (done.device_lost) return;
    RenderedFrame frame{meta, std::move(lease)};
    frame.meta.rendered = Clock::now();
    frame.meta.gpu = Nanoseconds(done.gpu_ns);
    frame.meta.readback = Nanoseconds(done.readback_ns);
    rendered(std::move(frame));
  };
}

void RenderLoop::recover(TimePoint now) {
  log::error("device lost: making it anew");
  if (auto rebuilt = device_.rebuild(now); !rebuilt) {
    failure_ = rebuilt.error();
    return;
  }
  lost_ = false;
  failed_submits_ = 0;
  log::info("device is back", {{"device", device_.renderer().device_name()}});
}

}  // namespace gnomon::daemon
