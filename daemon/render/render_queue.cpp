#include "daemon/render/render_queue.h"

#include <algorithm>
#include <cassert>
#include <utility>

namespace gnomon::daemon {

RenderQueue::RenderQueue(const SharingPolicy& sharing, Nanoseconds usual_quantum, SceneCosts& costs,
                         FrameSink& sink, Metrics& metrics)
    : usual_quantum_(usual_quantum), costs_(costs), sink_(sink), metrics_(metrics) {
  set_sharing(sharing, TimePoint{});
}

void RenderQueue::set_sharing(const SharingPolicy& sharing, TimePoint now) {
  const bool other_policy =
      !scheduler_ || sharing.policy != sharing_.policy || sharing.priority_floor != sharing_.priority_floor;
  sharing_ = sharing;
  account_.set_sharing(sharing);
  if (other_policy) {
    scheduler_ = scheduler::make_scheduler(sharing.policy, sharing.priority_floor);
    ++policy_;
  }
  for (uint32_t i = 0; i < sharing.tenants.size(); ++i) {
    scheduler_->set_tenant(TenantId{i}, sharing.tenants[i].scheduling);
  }
  for (auto& [id, session] : sessions_) {
    session.quality.set_limits(sharing.tenants[session.grant().tenant.value].degradation);
  }
  std::multimap<TimePoint, SessionId> looked_at_again;  // under the new rates
  for (const auto& [from, id] : held_) looked_at_again.emplace(now, id);
  held_.swap(looked_at_again);
  if (!other_policy) return;
  for (auto& [id, session] : sessions_) {
    scheduler_->add_session(id, session.grant().tenant);
    if (session.queued) enqueue(session, now);
  }
}

RenderSession* RenderQueue::find(SessionId id) {
  const auto found = sessions_.find(id);
  return found == sessions_.end() ? nullptr : &found->second;
}

void RenderQueue::open(const SessionOpened& opened) {
  const TenantId tenant = opened.grant.tenant;
  const auto [session, is_new] = sessions_.try_emplace(opened.session, opened, sink_, metrics_);
  assert(is_new);
  session->second.quality.set_limits(sharing_.tenants[tenant.value].degradation);
  scheduler_->add_session(opened.session, tenant);
}

void RenderQueue::close(SessionId id) {
  const RenderSession& session = sessions_.at(id);
  if (session.queued) account_.left_queue(session.grant().tenant);
  scheduler_->remove_session(id);
  sessions_.erase(id);
}

void RenderQueue::enqueue(RenderSession& session, TimePoint now) {
  cut_next_job(session);
  const TimePoint deadline = session.partial ? session.partial->meta.times.deadline : session.newest->deadline;
  scheduler_->make_ready(session.opened.session, {session.next.cost, deadline, session.partial.has_value()}, now);
  if (!std::exchange(session.queued, true)) account_.queued(session.grant().tenant);
}

void RenderQueue::enqueue_when_allowed(RenderSession& session, TimePoint now) {
  const TimePoint from = std::max(account_.eligible_at(session.grant().tenant), session.quality.eligible_at());
  if (from <= now) return enqueue(session, now);
  held_.emplace(from, session.opened.session);
  session.held = true;
}

void RenderQueue::release_held(TimePoint now) {
  while (!held_.empty() && held_.begin()->first <= now) {
    RenderSession* session = find(held_.begin()->second);
    held_.erase(held_.begin());
    if (!session) continue;
    session->held = false;
    if (session->newest && !session->partial) enqueue_when_allowed(*session, now);
  }
}

void RenderQueue::withdraw(RenderSession& session) {
  if (!std::exchange(session.queued, false)) return;
  account_.left_queue(session.grant().tenant);
  scheduler_->withdraw(session.opened.session);
}

void RenderQueue::requeue_scene(SceneId scene, TimePoint now) {
  for (auto& [id, session] : sessions_) {
    if (session.queued && session.grant().scene == scene) enqueue(session, now);
  }
}

void RenderQueue::forget_costs(SceneId scene, TimePoint now) {
  for (auto& [id, session] : sessions_) {
    if (session.grant().scene == scene) session.view = {};
  }
  requeue_scene(scene, now);
}

void RenderQueue::drop_expired(TimePoint now) {
  while (const auto id = scheduler_->take_expired(now)) {
    RenderSession& session = sessions_.at(*id);
    session.queued = false;
    session.newest.reset();
    account_.left_queue(session.grant().tenant);
    metrics_.dropped(session.grant().tenant, *id, Fault::deadline_unreachable);
  }
}

std::optional<RenderQueue::Picked> RenderQueue::pick(TimePoint now) {
  const auto ticket = scheduler_->pick(now);
  if (!ticket) return std::nullopt;
  RenderSession& session = sessions_.at(ticket->session);
  session.queued = false;
  account_.left_queue(session.grant().tenant);
  return Picked{session, *ticket};
}

void RenderQueue::charge(const scheduler::Ticket& ticket, uint64_t policy, Nanoseconds cost, TimePoint now) {
  if (policy == policy_) scheduler_->charge(ticket, cost, now);
}

void RenderQueue::cut_next_job(RenderSession& session, Nanoseconds quantum) {
  const SceneId scene = session.grant().scene;
  const SampleCounts samples = session.quality.samples();
  session.next =
      next_job(session, costs_.model_of(scene, samples), quantum, costs_.bits_within(scene, samples, quantum));
}

}  // namespace gnomon::daemon
