// How a connection becomes a session: a new one, or one that lost the connection before.
#include <asio/post.hpp>

#include "daemon/frame/translate.h"
#include "daemon/net/net_thread.h"
#include "daemon/security/random_bytes.h"
#include "daemon/session/credentials.h"
#include "daemon/session/resumption.h"

namespace gnomon::daemon {
namespace {

using protocol::RefusalCode;
using namespace std::chrono_literals;

constexpr const char* kNoSession = "no such session, or it is over";

protocol::Refused refusal_of(const scheduler::Misfit& misfit) {
  const bool size = misfit.limit == scheduler::Limit::size;
  std::string text("beyond the limit of ");
  text.append(to_string(misfit.limit));
  protocol::Refused refused = refusal(size ? RefusalCode::bad_size : RefusalCode::over_capacity, text);
  refused.fit_width = static_cast<uint16_t>(misfit.fit_width);
  refused.fit_height = static_cast<uint16_t>(misfit.fit_height);
  refused.fit_rate_hz = static_cast<float>(misfit.fit_rate_hz);
  return refused;
}

}  // namespace

void NetThread::adopt(asio::ip::tcp::socket socket) {
  asio::post(io_, [this, socket = std::move(socket)]() mutable { welcome_visitor(std::move(socket)); });
}

void NetThread::welcome_visitor(asio::ip::tcp::socket socket) {
  const std::shared_ptr<Tls> tls = *shared_.tls.get();
  auto stream = std::make_shared<ControlStream>(std::move(socket), tls->context, kMaxClientMessageBytes);
  for (const Visitor& pushed_out : lobby_.enter({stream, Clock::now() + shared_.config.server.handshake_timeout})) {
    if (!pushed_out.leaving) shared_.metrics.report(Fault::half_open_replaced);
    pushed_out.stream->close();
  }
  watch_visitor(stream, [this](const auto& visitor, Result<protocol::Message> message) {
    hear_visitor(visitor, std::move(message));
  });
  stream->start();
}

void NetThread::watch_visitor(const std::shared_ptr<ControlStream>& stream, OnVisitorMessage on_message) {
  const std::weak_ptr<ControlStream> weak = stream;
  stream->listen(
      [weak, on_message = std::move(on_message)](Result<protocol::Message> message) {
        if (const auto visitor = weak.lock()) on_message(visitor, std::move(message));
      },
      [this, weak](Fault fault, const std::string& why) {
        const auto visitor = weak.lock();
        if (visitor && lobby_.remove(visitor.get())) {
          shared_.metrics.report(fault, {{"why", why}, {"address", visitor->peer().to_string()}});
        }
      });
}

void NetThread::hear_visitor(const std::shared_ptr<ControlStream>& stream, Result<protocol::Message> message) {
  if (!message) return refuse(stream, refusal(RefusalCode::malformed, message.error().message));
  if (const auto* hello = std::get_if<protocol::Hello>(&*message)) return admit(stream, *hello);
  if (const auto* asked = std::get_if<protocol::Resume>(&*message)) return resume(stream, *asked);
  refuse(stream, refusal(RefusalCode::malformed, "the first message must be a Hello or a Resume"));
}

void NetThread::admit(const std::shared_ptr<ControlStream>& stream, const protocol::Hello& hello) {
  if (shared_.health.draining) return refuse(stream, refusal(RefusalCode::draining, "the server is going away"));
  if (const auto refused = check_version(hello)) return refuse(stream, *refused);
  const auto who = identify(hello, stream->certificate_names(), *shared_.roster.get(), shared_.config.server.mode);
  if (const auto* rejected = std::get_if<Rejected>(&who)) return refuse(stream, rejected->refused, rejected->fault);
  auto verdict = check_hello(hello, std::get<TenantId>(who), shared_.config,
                             [&](const auto& asked) { return shared_.catalog.find(asked); });
  if (const auto* refused = std::get_if<protocol::Refused>(&verdict)) return refuse(stream, *refused);
  seat(stream, std::get<SessionGrant>(std::move(verdict)), {});
}

// Who shows that it is the client of a session that is kept gets it, wherever the session is at the moment.
void NetThread::resume(const std::shared_ptr<ControlStream>& stream, const protocol::Resume& asked) {
  if (shared_.health.draining) return refuse(stream, refusal(RefusalCode::draining, "the server is going away"));
  const auto secret = shared_.store.resumption_secret(asked.session);
  const auto proof = stream->resumption_proof(asked.session, secret.value_or(protocol::Secret{}));
  if (!proof) return refuse(stream, refusal(RefusalCode::internal, proof.error().message));
  if (!protocol::is_equal(*proof, asked.proof) || !secret) {
    return refuse(stream, refusal(RefusalCode::unknown_session, kNoSession));
  }
  hold(stream);
  shared_.store.claim(asked.session, [this, weak = std::weak_ptr(stream)](KeptSession claimed) {
    auto kept = std::make_shared<KeptSession>(std::move(claimed));
    asio::post(io_, [this, weak, kept] {
      if (const auto waiting = held(weak)) resume(waiting, std::move(*kept));
    });
  });
}

void NetThread::resume(const std::shared_ptr<ControlStream>& stream, KeptSession kept) {
  if (!kept) return refuse(stream, refusal(RefusalCode::unknown_session, kNoSession));
  auto verdict = grant_of(kept.record(), *shared_.roster.get(), shared_.config,
                          [&](const auto& asked) { return shared_.catalog.find(asked); });
  if (const auto* refused = std::get_if<protocol::Refused>(&verdict)) return refuse(stream, *refused);
  seat(stream, std::get<SessionGrant>(std::move(verdict)), std::move(kept));
}

// The connection waits for an answer of ours.
void NetThread::hold(const std::shared_ptr<ControlStream>& stream) {
  lobby_.remove(stream.get());
  lobby_.enter({stream, TimePoint::max()});
  watch_visitor(stream, [this](const auto& visitor, Result<protocol::Message>) {
    refuse(visitor, refusal(RefusalCode::malformed, "a message before the first one was answered"));
  });
}

// Null: it does not wait any more.
std::shared_ptr<ControlStream> NetThread::held(const std::weak_ptr<ControlStream>& stream) const {
  auto waiting = stream.lock();
  return waiting && lobby_.hosts(waiting.get()) ? waiting : nullptr;
}

void NetThread::seat(const std::shared_ptr<ControlStream>& stream, const SessionGrant& grant, KeptSession kept) {
  auto seat = shared_.seats.take(grant.tenant, stream->peer());
  if (const auto* refused = std::get_if<protocol::Refused>(&seat)) {
    shared_.metrics.refused(grant.tenant, to_string(scheduler::Limit::sessions));
    return refuse(stream, *refused);
  }
  hold(stream);
  const auto applicant = std::make_shared<Applicant>(Applicant{
      .stream = stream, .grant = grant, .kept = std::move(kept), .seat = std::get<Seat>(std::move(seat))});
  shared_.scenes.fetch(grant.scene_name, [this, applicant](Result<SceneForUse> scene) {
    asio::post(io_, [this, applicant, scene = std::move(scene)] { open_with(applicant, scene); });
  });
}

void NetThread::open_with(const ApplicantPtr& applicant, const Result<SceneForUse>& scene) {
  const auto stream = held(applicant->stream);
  if (!stream) return;
  if (!scene) return refuse(stream, refusal(RefusalCode::scene_unavailable, scene.error().message));
  if (applicant->kept && applicant->kept.record().scene_hash != scene->scene->content_hash) {
    return refuse(stream, refusal(RefusalCode::unknown_session, "the scene is another one now"));
  }
  applicant->scene_use = scene->use;
  applicant->grant.scene = scene->id;
  applicant->grant.lights = static_cast<uint32_t>(scene->scene->lights.size());
  if (book(stream, *applicant)) ask_room(applicant, *scene);
}

// False: refused.
bool NetThread::book(const std::shared_ptr<ControlStream>& stream, Applicant& applicant) {
  const SessionGrant& grant = applicant.grant;
  const CostModels costs = shared_.devices.costs();
  const auto known = costs.find(grant.scene);
  const auto misfit = shared_.seats.book(applicant.seat, {grant.width, grant.height, grant.lights, grant.rate_hz},
                                         known == costs.end() ? scheduler::CostModel() : known->second);
  if (!misfit) return true;
  shared_.metrics.refused(grant.tenant, to_string(misfit->limit));
  refuse(stream, refusal_of(*misfit));
  return false;
}

void NetThread::ask_room(const ApplicantPtr& applicant, const scenes::LoadedScene& scene) {
  const auto decide = [this, applicant, scene](const Result<void>& room) {
    const auto stream = held(applicant->stream);
    if (!stream) return;
    const TenantId tenant = applicant->grant.tenant;
    if (!shared_.roster.get()->open(tenant)) {
      return refuse(stream, refusal(RefusalCode::unknown_tenant, "the tenant is no longer served"));
    }
    if (room) return open_session(stream, *applicant, scene);
    shared_.metrics.refused(tenant, to_string(scheduler::Limit::memory));
    refuse(stream, refusal(RefusalCode::over_capacity, "no memory for its frames: " + room.error().message));
  };
  const SessionGrant& grant = applicant->grant;
  shared_.devices.ask_room({.scene = grant.scene,
                            .tenant = grant.tenant,
                            .width = grant.width,
                            .height = grant.height,
                            .answer = [this, decide](Result<void> room) {
                              asio::post(io_, [decide, room = std::move(room)] { decide(room); });
                            }});
}

// Makes the seal of a new session, with its state where it is kept, if it may be resumed and there is room.
Result<KeptSession> NetThread::keep_new(ControlStream& stream, const SessionGrant& grant,
                                        const scenes::LoadedScene& scene, SessionId id,
                                        std::unique_ptr<protocol::Seal>& seal) {
  const auto secrets = stream.seal_secrets(id, grant.cipher);
  if (!secrets) return secrets.error();
  KeptSession kept;
  if (grant.has(protocol::kFeatureResume)) {
    const auto resumption = stream.resumption_secret(id);
    if (!resumption) return resumption.error();
    kept = shared_.store.add(record_of(id, grant, shared_.roster.get()->name(grant.tenant),
                                       {.scene_hash = scene.scene->content_hash,
                                        .resumption = *resumption,
                                        .seal = protocol::first_state(*secrets, protocol::Side::server)}));
  }
  if (!kept) seal = std::make_unique<protocol::Seal>(id, grant.cipher, *secrets, protocol::Side::server);
  return kept;
}

void NetThread::open_session(const std::shared_ptr<ControlStream>& stream, Applicant& applicant,
                             const scenes::LoadedScene& scene) {
  SessionGrant& grant = applicant.grant;
  KeptSession kept = std::move(applicant.kept);
  const bool resumed = static_cast<bool>(kept);
  const SessionId id = resumed ? SessionId{kept.record().id} : random_session_id();
  std::unique_ptr<protocol::Seal> seal;
  if (!resumed) {
    auto made = keep_new(*stream, grant, scene, id, seal);
    if (!made) return refuse(stream, refusal(RefusalCode::internal, made.error().message));
    kept = std::move(*made);
  }
  if (kept) {
    kept.record().life += resumed;
    seal = std::make_unique<protocol::Seal>(id, grant.cipher, kept.record().seal, protocol::Side::server);
    kept.when_wanted([this, id] {
      asio::post(io_, [this, id] { leave_session(id, "its client has come back on another connection"); });
    });
  } else {
    grant.features &= ~protocol::kFeatureResume;
  }
  const Session& session =
      sessions_.add(std::make_unique<Session>(SessionParts{.id = id,
                                                           .grant = grant,
                                                           .seal = std::move(seal),
                                                           .seat = std::move(applicant.seat),
                                                           .kept = std::move(kept),
                                                           .scene_use = std::move(applicant.scene_use)},
                                              Clock::now()));
  lobby_.remove(stream.get());
  streams_.emplace(id, stream);
  stream->listen([this, id](Result<protocol::Message> message) { hear_client(id, std::move(message)); },
                 [this, id](Fault, const std::string& why) { lose_control(id, why); });
  shared_.devices.open({.session = id,
                        .grant = grant,
                        .net_thread = index_,
                        .references = session.references(),
                        .life = session.life()});
  shared_.metrics.session_opened(grant.tenant);
  greet(*stream, session, scene);
  log::info(resumed ? "session resumed" : "session opened",
            {{"session", id.value},
             {"tenant", shared_.roster.get()->name(grant.tenant)},
             {"scene", grant.scene_name},
             {"size", std::to_string(grant.width) + "x" + std::to_string(grant.height)},
             {"address", stream->peer().to_string()}});
}

void NetThread::greet(ControlStream& stream, const Session& session, const scenes::LoadedScene& scene) {
  const SessionGrant& grant = session.grant();
  protocol::Welcome welcome;
  welcome.features = grant.features;
  welcome.session = session.id();
  welcome.data_port = data_->port();
  welcome.cipher = grant.cipher;
  welcome.width = grant.width;
  welcome.height = grant.height;
  welcome.rate_hz = grant.rate_hz;
  welcome.codec = grant.codec;
  welcome.passes = shared_.config.render.passes;
  welcome.tracer = shared_.tracer;
  welcome.silence_timeout_ms = static_cast<uint32_t>(shared_.config.server.silence_timeout.count());
  welcome.scene = manifest_of(*scene.scene, grant.scene_name, float(grant.width) / float(grant.height));
  const LightsNews news = shared_.scenes.lights_of(grant.scene_name);
  welcome.scene.lights = to_wire(news.lights);
  welcome.lights_version = news.version;
  welcome.motions = to_wire(shared_.catalog.motions(grant.scene_name));
  stream.send(welcome);
}

void NetThread::refuse(const std::shared_ptr<ControlStream>& stream, const protocol::Refused& refused) {
  refuse(stream, refused, fault_of(refused.code));
}

void NetThread::refuse(const std::shared_ptr<ControlStream>& stream, const protocol::Refused& refused,
                       Fault fault) {
  shared_.metrics.report(
      fault, {{"reason", row_of(fault).label}, {"text", refused.text}, {"address", stream->peer().to_string()}});
  lobby_.remove(stream.get());
  stream->send(refused);
  show_out(stream);
}

}  // namespace gnomon::daemon
