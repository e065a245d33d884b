#include "daemon/render/render_loop.h"

#include <utility>

#include "daemon/frame/translate.h"
#include "daemon/render/light_importance.h"

namespace gnomon::daemon {
namespace {

// A model that moves by so much at once has met something new.
constexpr double kSurprise = 1.25;

// Before the device runs dry: what waking up, recording and submitting take.
constexpr Nanoseconds kLead = std::chrono::milliseconds(1);

// A camera that comes a little early is no offence.
scheduler::RateLimit limit_to(double rate_hz) {
  const std::chrono::duration<double> early(rate_hz > 0 ? 1.5 / rate_hz : 0);
  return scheduler::RateLimit(rate_hz, std::chrono::duration_cast<Nanoseconds>(early));
}

FrameMeta meta_of(const RenderSession& session, const ViewRequest& view, uint32_t device, TimePoint now) {
  return {.route = {.session = view.session,
                    .tenant = session.grant().tenant,
                    .scene = session.grant().scene,
                    .net_thread = session.opened.net_thread,
                    .device = device,
                    .frame = view.frame},
          .spec = {.codec = session.link.dense() ? session.grant().dense_codec : session.codec,
                   .slice_body_bytes = view.slice_body_bytes,
                   .references = session.opened.references,
                   .camera = view.camera,
                   .grid = session.grid(),
                   .tells_size = session.grant().has(protocol::kFeatureSizes) && !session.has_granted_size(),
                   .traced_lights = session.traced_lights()},
          .times = {.arrival = view.arrival, .deadline = view.deadline, .submitted = now},
          .coalesced = session.coalesced};
}

}  // namespace

RenderLoop::RenderLoop(const Terms& terms, RenderDevice& device, RenderInbox& inbox, Metrics& metrics,
                       FrameSink& sink)
    : device_(device),
      inbox_(inbox),
      metrics_(metrics),
      sink_(sink),
      usual_slice_(device.renderer().info().on_cpu ? kSliceOfCpu : kSliceOfGpu),
      motion_(device, metrics, sink) {
  apply(terms, TimePoint{});
}

void RenderLoop::start(TimePoint now) {
  if (lost_ && in_flight_ == 0 && submits_ == 0 && !stopping_ && !failure_) recover(now);
  if (lost_ || failure_) return;
  for (const SceneId scene : motion_.step(now)) meet_new_costs(scene, now);
  release_held(now);
  room_at_ = TimePoint::max();
  if (!has_room(now)) return;
  account_.look();
  device_.renderer().begin_batch();
  while (!lost_ && has_room(now)) {
    drop_hopeless(now);
    const auto ticket = scheduler_->pick(now);
    if (!ticket) break;
    submit(sessions_.at(ticket->session), *ticket, now);
  }
  device_.renderer().end_batch();
}

// Of frames there are no more than the encoders can take. Of work on the device there is what keeps it busy: the next
// job follows when, as far as predictions go, it is about to run dry. Submitted earlier it would only stand before
// whoever comes next; and where predictions fail, there are never more than two jobs of full length.
bool RenderLoop::has_room(TimePoint now) {
  if (device_.renderer().free_slots() == 0 || in_flight_ - begun_ >= terms_.frames_in_flight) return false;
  if (submits_ == 0 || slice() <= Nanoseconds{}) return true;
  if (predicted_ > slice() / 2) return false;
  const TimePoint soon_dry = runs_dry_ - std::min(kLead, slice() / 4);
  if (soon_dry > now) room_at_ = soon_dry;
  return soon_dry <= now;
}

Nanoseconds RenderLoop::slice() const { return terms_.slice.value_or(usual_slice_); }

void RenderLoop::handle(RenderEvent event, TimePoint now) {
  std::visit([&](const auto& e) { on(e, now); }, event);
}

TimePoint RenderLoop::wake_at() const {
  return held_.empty() ? room_at_ : std::min(room_at_, held_.begin()->first);
}

ShareReport RenderLoop::shares() { return account_.report(*scheduler_); }

void RenderLoop::on(const ViewRequest& view, TimePoint now) {
  if (stopping_) return metrics_.report(view.tenant, view.session, Fault::view_draining);
  const auto found = sessions_.find(view.session);
  if (found == sessions_.end()) return metrics_.report(view.tenant, view.session, Fault::session_gone);
  RenderSession& session = found->second;
  ++session.arrived;
  session.coalesced += view.coalesced;
  if (session.newest) {
    ++session.coalesced;
    metrics_.coalesced(session.grant().tenant);
  }
  // A session that has moved may hear of an older view from the device where it was.
  if (!session.newest || session.newest->frame.value <= view.frame.value) session.newest = view;
  if (!session.begun && !session.held) ask_when_allowed(session, now);
}

// Later, frames that find no memory become smaller than that. Who has none yet may find another node.
void RenderLoop::on(const RoomAsked& asked, TimePoint now) {
  if (lost_ || stopping_) return asked.answer({});
  const double least = terms_.tenants[asked.tenant.value].degradation.least_size;
  gpu::RenderJob like;
  like.scene = asked.scene;
  like.width = shrunk(asked.width, least);
  like.height = shrunk(asked.height, least);
  like.time = motion_.time_of(asked.scene, now);
  asked.answer(device_.renderer().make_room(like));
}

void RenderLoop::on(const SessionOpened& opened, TimePoint) {
  RenderSession session(opened);
  session.rate = limit_to(opened.grant.rate_hz);
  set_terms(session);
  sessions_.emplace(opened.session, std::move(session));
  scheduler_->add_session(opened.session, opened.grant.tenant);
}

void RenderLoop::on(const SessionClosed& closed, TimePoint) {
  const auto found = sessions_.find(closed.session);
  if (found == sessions_.end()) return;
  RenderSession& session = found->second;
  if (session.has_work()) metrics_.dropped(session.grant().tenant, closed.session, Fault::session_gone);
  forget(closed.session);
}

// What is on the device of its frames is sent; one of which not all bands were submitted is lost.
void RenderLoop::on(const SessionLeaves& leaves, TimePoint) {
  const auto found = sessions_.find(leaves.session);
  if (found == sessions_.end()) return;
  if (found->second.newest) leaves.to->push_view(*found->second.newest);
  forget(leaves.session);
}

void RenderLoop::forget(SessionId id) {
  RenderSession& session = sessions_.at(id);
  if (session.asked) account_.left_queue(session.grant().tenant);
  if (session.begun) abandon(session);
  scheduler_->remove_session(id);
  sessions_.erase(id);
}

void RenderLoop::on(const CodecChosen& chosen, TimePoint) {
  const auto found = sessions_.find(chosen.session);
  if (found != sessions_.end()) found->second.codec = chosen.codec;
}

void RenderLoop::on(const SceneArrived& arrived, TimePoint) {
  if (stopping_) return arrived.resident(Error{"the server is stopping"});
  if (lost_) return waiting_.push_back(arrived);
  device_.bring_scene(arrived.scene, [this, arrived](Result<gpu::SceneFootprint> made) {
    if (made) motion_.add(arrived.scene.id, arrived.name, arrived.scene);
    arrived.resident(std::move(made));
  });
}

void RenderLoop::on(const SceneLeaves& leaves, TimePoint) {
  std::erase_if(waiting_, [&](const RenderEvent& event) {
    const auto* arrived = std::get_if<SceneArrived>(&event);
    return arrived && arrived->scene.id == leaves.scene;
  });
  device_.remove_scene(leaves.scene);
  motion_.remove(leaves.scene);
}

void RenderLoop::on(const LightChanged& changed, TimePoint now) {
  if (lost_) return waiting_.push_back(changed);
  motion_.change(changed.scene, changed.light, changed.change, now);
}

void RenderLoop::on(const JobFinished& job, TimePoint now) {
  --submits_;
  predicted_ -= job.ticket.predicted;
  runs_dry_ = now + predicted_;
  if (job.policy == policy_) scheduler_->charge(job.ticket, job.gpu, now);
  account_.finished(job.ticket.tenant, job.ticket.predicted, job.gpu, now);
  metrics_.device_busy(device_.number(), job.ticket.tenant, job.gpu);
  if (job.device_lost) {
    metrics_.dropped(job.ticket.tenant, job.ticket.session, Fault::device_lost);
    return lose_device();
  }
  if (job.out_of_memory) return not_afforded(job, now);
  scheduler::CostModel& model = (job.unbuilt ? unbuilt_models_ : models_)[job.scene];
  const auto found = sessions_.find(job.ticket.session);
  if (found != sessions_.end()) found->second.view.learn(job.model_cost, {job.gpu - job.trace, job.trace});
  const double before = to_seconds(model.predict(job.work).total());
  model.learn(job.work, job.gpu, job.trace);
  const double after = to_seconds(model.predict(job.work).total());
  if (before > kSurprise * after || after > kSurprise * before) ask_anew(job.scene, now);
}

// The frame is lost with the band that was not started. Who gave it up before has counted it.
void RenderLoop::not_afforded(const JobFinished& job, TimePoint now) {
  const auto found = sessions_.find(job.ticket.session);
  const bool begun = found != sessions_.end() && found->second.begun && found->second.begun->job == job.job;
  if (!begun && !job.last) return;
  metrics_.dropped(job.ticket.tenant, job.ticket.session, Fault::submit_failed, "no memory to start it");
  if (!begun) return;
  RenderSession& session = found->second;
  give_up_begun(session);
  if (session.newest && !session.held) ask_when_allowed(session, now);
}

// While a hierarchy answers for a scene, its frames cost many times what they will: that is learned apart, and what
// sessions are admitted by does not know it.
scheduler::CostModel& RenderLoop::model_of(SceneId scene) {
  return (motion_.unbuilt(scene) ? unbuilt_models_ : models_)[scene];
}

void RenderLoop::meet_new_costs(SceneId scene, TimePoint now) {
  for (auto& [id, session] : sessions_) {
    if (session.grant().scene == scene) session.view = {};
  }
  ask_anew(scene, now);
}

// Those who wait stand in the queue with what was believed when they asked.
void RenderLoop::ask_anew(SceneId scene, TimePoint now) {
  for (auto& [id, session] : sessions_) {
    if (session.asked && session.grant().scene == scene) ask(session, now);
  }
}

void RenderLoop::on(const LeaseDropped&, TimePoint) { --in_flight_; }

void RenderLoop::on(const BytesSent& sent, TimePoint now) {
  account_.sent(sent.tenant, sent.bytes, now);
  models_[sent.scene].learn_bytes(sent.bits, sent.bytes);
}

void RenderLoop::on(const TermsChanged& changed, TimePoint now) { apply(changed.terms, now); }

void RenderLoop::on(const TenantPart& part, TimePoint) { account_.set_part(part.tenant, part.part); }

void RenderLoop::on(const StopRendering&, TimePoint) {
  stopping_ = true;
  refuse_waiting(Error{"the server is stopping"});
  for (auto& [id, session] : sessions_) {
    if (session.has_work()) metrics_.dropped(session.grant().tenant, id, Fault::view_draining);
    if (session.asked) account_.left_queue(session.grant().tenant);
    if (session.begun) abandon(session);
    scheduler_->remove_session(id);
  }
  sessions_.clear();
}

// Another policy starts with everybody who waits; what was charged before is not held against anybody.
void RenderLoop::apply(const Terms& terms, TimePoint now) {
  const bool other_policy =
      !scheduler_ || terms.policy != terms_.policy || terms.priority_floor != terms_.priority_floor;
  terms_ = terms;
  account_.set_terms(terms);
  if (other_policy) {
    scheduler_ = scheduler::make_scheduler(terms.policy, terms.priority_floor);
    ++policy_;
  }
  for (uint32_t i = 0; i < terms.tenants.size(); ++i) {
    scheduler_->set_tenant(TenantId{i}, terms.tenants[i].terms);
  }
  for (auto& [id, session] : sessions_) set_terms(session);
  if (!other_policy) return;
  for (auto& [id, session] : sessions_) {
    scheduler_->add_session(id, session.grant().tenant);
    if (session.asked) ask(session, now);
  }
}

void RenderLoop::ask_when_allowed(RenderSession& session, TimePoint now) {
  const TimePoint from = std::max(account_.open_at(session.grant().tenant), session.rate.open_at());
  if (from <= now) return ask(session, now);
  session.held = true;
  held_.emplace(from, session.opened.session);
}

void RenderLoop::release_held(TimePoint now) {
  while (!held_.empty() && held_.begin()->first <= now) {
    const auto found = sessions_.find(held_.begin()->second);
    held_.erase(held_.begin());
    if (found == sessions_.end()) continue;
    found->second.held = false;
    if (found->second.newest && !found->second.begun) ask_when_allowed(found->second, now);
  }
}

void RenderLoop::ask(RenderSession& session, TimePoint now) {
  session.next = next_job(session, model_of(session.grant().scene), slice());
  const TimePoint deadline = session.begun ? session.begun->meta.times.deadline : session.newest->deadline;
  scheduler_->make_ready(session.opened.session, {session.next.cost, deadline, session.begun.has_value()}, now);
  if (!std::exchange(session.asked, true)) account_.asked(session.grant().tenant);
}

void RenderLoop::drop_hopeless(TimePoint now) {
  while (const auto id = scheduler_->take_hopeless(now)) {
    RenderSession& session = sessions_.at(*id);
    session.asked = false;
    session.newest.reset();
    account_.left_queue(session.grant().tenant);
    metrics_.dropped(session.grant().tenant, *id, Fault::view_hopeless);
  }
}

void RenderLoop::submit(RenderSession& session, const scheduler::Ticket& ticket, TimePoint now) {
  session.asked = false;
  account_.left_queue(session.grant().tenant);
  if (session.begun) return resume(session, ticket, now);
  if (account_.open_at(session.grant().tenant) > now) {  // others of its tenant were faster
    scheduler_->charge(ticket, Nanoseconds{}, now);
    return ask_when_allowed(session, now);
  }
  begin(session, ticket, now);
}

// The camera is the newest there is at this moment.
void RenderLoop::begin(RenderSession& session, const scheduler::Ticket& ticket, TimePoint now) {
  const ViewRequest view = *std::exchange(session.newest, std::nullopt);
  if (session.memory.recover(now)) metrics_.degraded(false);
  if (session.wanted_grid() != session.grid()) adopt_size(session);
  const gpu::CameraView camera = to_gpu(view.camera);
  choose_lights(session, camera);
  const uint32_t all_rows = session.grid().tiles_y();
  // A frame that is cut holds a slot for long: the last one is for those that are done at once.
  if (session.next.rows.count < all_rows && device_.renderer().free_slots() < 2) {
    session.next = next_job(session, model_of(session.grant().scene), Nanoseconds{});
  }
  const uint32_t rows = session.next.rows.count;
  BegunFrame frame{JobId{next_job_++}, meta_of(session, view, device_.number(), now), 0,
                   motion_.unbuilt(session.grant().scene)};
  gpu::RenderJob job{frame.job, session.grant().scene, camera, session.width, session.height};
  job.untraced = session.untraced;
  if (rows < all_rows) job.tile_rows = rows;
  job.time = motion_.time_of(session.grant().scene, now);
  if (session.grant().has(protocol::kFeatureMoments))
    frame.meta.spec.moment = motion_.moment_of(session.grant().scene, now);
  const auto submitted = device_.renderer().submit(job, completion(session, ticket, frame));
  if (!submitted) {
    if (shrink(session, ticket, view, now, submitted.error())) return;
    return not_started(session, ticket, now, submitted.error());
  }
  session.coalesced = 0;
  ++session.answered;
  session.rate.spend(1, now);
  ++in_flight_;
  ++begun_;
  session.begun = std::move(frame);
  started(session, ticket, now);
}

// No memory for a frame of this size: the same view is asked for again, smaller. False: it cannot be smaller.
bool RenderLoop::shrink(RenderSession& session, const scheduler::Ticket& ticket, const ViewRequest& view,
                        TimePoint now, const Error& error) {
  do {
    if (!session.memory.refuse(now)) return false;
  } while (session.wanted_grid() == session.grid());
  metrics_.degraded(true);
  log::warning("smaller frames for a session", {{"session", ticket.session.value},
                                                {"tenant", metrics_.name(ticket.tenant)},
                                                {"width", session.wanted_grid().width},
                                                {"height", session.wanted_grid().height},
                                                {"why", error.message}});
  scheduler_->charge(ticket, Nanoseconds{}, now);
  session.newest = view;
  ask_when_allowed(session, now);
  return true;
}

// Frames change their size between two, never within one.
void RenderLoop::adopt_size(RenderSession& session) {
  const TileGrid wanted = session.wanted_grid();
  session.width = wanted.width;
  session.height = wanted.height;
  session.next = next_job(session, model_of(session.grant().scene), slice());
  tell(session);
}

// What is left out is chosen for each frame anew, and changes seldom.
void RenderLoop::choose_lights(RenderSession& session, const gpu::CameraView& camera) {
  const size_t keep = session.wanted_lights();
  if (keep >= session.grant().lights && session.untraced.none()) return;
  const gpu::LightSet untraced =
      least_important(motion_.lights_of(session.grant().scene), camera.position, keep, session.untraced);
  if (untraced == session.untraced) return;
  session.untraced = untraced;
  session.next = next_job(session, model_of(session.grant().scene), slice());
  tell(session);
}

void RenderLoop::set_terms(RenderSession& session) {
  const scheduler::DegradationTerms& terms = terms_.tenants[session.grant().tenant.value].degradation;
  session.degradation.set_terms(terms);
  session.link.set_terms(terms, session.grant().dense_codec != session.codec);
}

void RenderLoop::on(const LinkReviewed& reviewed, TimePoint) {
  const auto found = sessions_.find(reviewed.session);
  if (found == sessions_.end()) return;
  RenderSession& session = found->second;
  const double before = session.link.size() - (session.link.dense() ? 1 : 0);
  if (!session.link.observe(reviewed.window)) return;
  const double after = session.link.size() - (session.link.dense() ? 1 : 0);
  metrics_.degraded(after < before);
}

void RenderLoop::tell(const RenderSession& session) {
  protocol::Degraded news;
  news.width = static_cast<uint16_t>(session.width);
  news.height = static_cast<uint16_t>(session.height);
  news.rate_hz = static_cast<float>(session.rate_hz());
  for (uint16_t light = 0; light < session.grant().lights; ++light) {
    if (session.untraced[light]) news.untraced_lights.push_back(light);
  }
  const bool full = session.degradation.point() == scheduler::OperatingPoint{};
  if (session.memory.size() < 1) {
    news.reason = "the device has no memory for more";
  } else if (session.link.size() < 1) {
    news.reason = "the link cannot carry more";
  } else {
    news.reason = full ? "the device keeps up again" : "the device cannot keep up";
  }
  sink_.on_degraded({session.opened.session, session.opened.net_thread, news, session.opened.life});
}

// Who has no rate of its own asks again when it is answered: it cannot be overrun.
void RenderLoop::review_sessions(Nanoseconds since_last) {
  for (auto& [id, session] : sessions_) {
    const uint32_t arrived = std::exchange(session.arrived, 0), answered = std::exchange(session.answered, 0);
    if (session.grant().rate_hz <= 0) continue;
    const auto allowed = static_cast<uint32_t>(session.rate_hz() * to_seconds(since_last));
    const scheduler::OperatingPoint before = session.degradation.point();
    if (!session.degradation.observe({std::min(arrived, allowed), answered})) continue;
    const scheduler::OperatingPoint after = session.degradation.point();
    metrics_.degraded(after.rate * after.size * after.lights < before.rate * before.size * before.lights);
    session.rate = limit_to(session.rate_hz());
    if (after.rate != before.rate) tell(session);
  }
}

void RenderLoop::resume(RenderSession& session, const scheduler::Ticket& ticket, TimePoint now) {
  const BegunFrame& frame = *session.begun;
  const auto submitted =
      device_.renderer().resume(frame.job, session.next.rows.count, completion(session, ticket, frame));
  if (submitted) return started(session, ticket, now);
  abandon(session);
  not_started(session, ticket, now, submitted.error());
}

void RenderLoop::started(RenderSession& session, const scheduler::Ticket& ticket, TimePoint now) {
  ++submits_;
  predicted_ += ticket.predicted;
  runs_dry_ = std::max(runs_dry_, now) + ticket.predicted;
  const scheduler::Work& work = session.next.work;
  account_.started(session.grant().tenant, work.begins, work.bits, now);
  session.begun->next_row += session.next.rows.count;
  if (session.begun->next_row < session.grid().tiles_y()) return ask(session, now);
  session.begun.reset();
  --begun_;
  if (session.newest) ask_when_allowed(session, now);
}

void RenderLoop::not_started(RenderSession& session, const scheduler::Ticket& ticket, TimePoint now,
                             const Error& error) {
  scheduler_->charge(ticket, Nanoseconds{}, now);
  metrics_.dropped(ticket.tenant, ticket.session, Fault::submit_failed, error.message);
  if (session.newest) ask_when_allowed(session, now);
}

// The function runs on the completion thread: the news comes back here, the mask goes on to be encoded.
std::function<void(gpu::FrameDone)> RenderLoop::completion(const RenderSession& session,
                                                           const scheduler::Ticket& ticket,
                                                           const BegunFrame& frame) {
  JobFinished job;
  job.job = frame.job;
  job.ticket = ticket;
  job.policy = policy_;
  job.scene = session.grant().scene;
  job.work = session.next.work;
  job.model_cost = session.next.model_cost;
  job.unbuilt = frame.unbuilt;
  return [job, meta = frame.meta, &inbox = inbox_, &sink = sink_](gpu::FrameDone done) mutable {
    job.gpu = Nanoseconds(done.gpu_ns);
    job.trace = Nanoseconds(done.trace_ns);
    job.device_lost = done.device_lost;
    job.out_of_memory = done.out_of_memory;
    job.last = done.complete;
    inbox.push(job);
    if (!done.complete || done.device_lost || done.out_of_memory) return;
    meta.times.rendered = done.completed_at;
    meta.times.gpu = Nanoseconds(done.frame_gpu_ns);
    meta.times.readback = Nanoseconds(done.readback_ns);
    sink.on_rendered({std::move(meta), std::move(done.mask)});
  };
}

// Its bands on the device are done, but nobody will see them.
void RenderLoop::abandon(RenderSession& session) {
  device_.renderer().abandon(session.begun->job);
  session.begun.reset();
  --begun_;
  --in_flight_;
}

// And takes its session out of the queue, where it stands for the next band.
void RenderLoop::give_up_begun(RenderSession& session) {
  abandon(session);
  if (!std::exchange(session.asked, false)) return;
  account_.left_queue(session.grant().tenant);
  scheduler_->withdraw(session.opened.session);
}

// Frames in bands are lost with it; whoever has a newer view asks again.
void RenderLoop::lose_device() {
  if (!lost_) metrics_.device_lost(device_.number());
  lost_ = true;
  for (auto& [id, session] : sessions_) {
    if (!session.begun) continue;
    give_up_begun(session);
    if (session.newest && !session.held) ask_when_allowed(session, TimePoint::max());
  }
}

void RenderLoop::refuse_waiting(const Error& why) {
  device_.refuse_arriving(why);
  for (const RenderEvent& event : std::exchange(waiting_, {})) {
    if (const auto* arrived = std::get_if<SceneArrived>(&event)) arrived->resident(why);
  }
}

void RenderLoop::recover(TimePoint now) {
  log::error("device lost: making it anew", {{"number", device_.number()}});
  if (auto rebuilt = device_.rebuild(now); !rebuilt) {
    failure_ = rebuilt.error();
    refuse_waiting(*failure_);
    return;
  }
  lost_ = false;
  motion_.restore();
  log::info("device is back", {{"number", device_.number()}, {"device", device_.renderer().info().name}});
  for (RenderEvent& event : std::exchange(waiting_, {})) handle(std::move(event), now);
}

}  // namespace gnomon::daemon
