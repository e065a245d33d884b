#include "daemon/net/admission.h"

#include <asio/co_spawn.hpp>
#include <asio/detached.hpp>
#include <asio/steady_timer.hpp>
#include <asio/use_awaitable.hpp>

#include "common/within_memory.h"
#include "daemon/net/answer.h"
#include "daemon/net/web_exchange.h"
#include "daemon/net/welcome.h"
#include "daemon/net/words_for_clients.h"
#include "daemon/scenes/scene_fetches.h"
#include "daemon/security/random_bytes.h"
#include "daemon/session/credentials.h"
#include "daemon/session/resumption.h"

namespace gnomon::daemon {
namespace {

using protocol::RefusalCode;

using namespace std::chrono_literals;

constexpr std::chrono::milliseconds kFirstNews = 500ms;  // a client hears within a second what it waits for
constexpr std::chrono::milliseconds kBetweenNews = 1s;
constexpr double kRequestsAtOnce_s = 20;  // of what web.requests_per_s allows: a first page is some 90 files

constexpr const char* kGoingAway = "the server is going away";
constexpr const char* kNoSession = "no such session, or it is over";

}  // namespace

Admission::Admission(const NetShared& shared, uint16_t data_port, asio::io_context& io, SessionControl& control,
                     PendingConnections& pending)
    : shared_(shared),
      data_port_(data_port),
      io_(io),
      control_(control),
      pending_(pending),
      web_requests_(kRequestsAtOnce_s * shared.config.web.requests_per_s, shared.config.web.requests_per_s) {}

void Admission::on_accept(asio::ip::tcp::socket socket, const asio::ip::address& client) {
  const std::shared_ptr<Tls> tls = *shared_.tls.get();
  auto stream = std::make_shared<ControlStream>(std::move(socket), client, tls->context, kMaxClientMessageBytes);
  const auto deadline = Clock::now() + shared_.config.server.handshake_timeout;
  if (const PendingConnection pushed_out = pending_.add(stream, deadline); pushed_out.stream) {
    if (!pushed_out.leaving) {
      shared_.metrics.report(Fault::half_open_replaced, {{"address", pushed_out.stream->peer().to_string()}});
    }
    pushed_out.stream->close();
  }
  listen(
      stream,
      [this](const StreamPtr& from, Result<protocol::Message> message) {
        on_first_message(from, std::move(message));
      },
      std::stop_source(std::nostopstate));
  if (shared_.web) {
    stream->listen_to_browser(std::make_shared<WebExchange>(shared_, io_, pending_, *stream, web_requests_));
  }
  stream->start();
}

void Admission::close_overdue(TimePoint now) {
  for (const PendingConnection& connection : pending_.expire(now)) {
    const bool leaves = connection.leaving || connection.stream->is_idle_browser();
    if (!leaves) {
      const Fault fault = connection.stream->is_browser() ? Fault::web_stalled : Fault::handshake_timeout;
      shared_.metrics.report(fault, {{"address", connection.stream->peer().to_string()}});
    }
    connection.stream->close();
  }
}

void Admission::on_first_message(const StreamPtr& stream, Result<protocol::Message> message) {
  if (!message) return refuse(stream, refused(RefusalCode::malformed, message.error().message), Claim{});
  if (std::holds_alternative<protocol::Bye>(*message)) return on_bye(stream);
  asio::co_spawn(io_, admit(stream, std::move(*message)), asio::detached);
}

asio::awaitable<void> Admission::admit(StreamPtr stream, protocol::Message first) {
  Applicant applicant{.stream = std::move(stream)};
  if (has_departed(applicant)) co_return;  // before this coroutine was started
  Verdict refusal;
  bool enough_memory = true;
  try {
    refusal = co_await take_steps(applicant, first);
  } catch (const std::bad_alloc&) {
    enough_memory = false;
  }
  if (enough_memory && !refusal) co_return;
  const bool refused_politely = done_or_dropped("a refusal", [&] {
    if (!enough_memory) refusal = refused(RefusalCode::internal, "the server has no memory for it");
    refuse(applicant.stream, *refusal, applicant.claim, applicant.grant.tenant);
  });
  if (refused_politely) co_return;
  pending_.remove(applicant.stream.get());
  applicant.stream->close();
}

asio::awaitable<Admission::Verdict> Admission::take_steps(Applicant& applicant, const protocol::Message& first) {
  if (const auto* hello = std::get_if<protocol::Hello>(&first)) {
    if (auto refusal = identify(applicant, *hello)) co_return refusal;
  } else if (const auto* resume = std::get_if<protocol::Resume>(&first)) {
    if (auto refusal = co_await reclaim(applicant, *resume)) co_return refusal;
  } else {
    co_return refused(RefusalCode::malformed, "the first message must be a Hello or a Resume");
  }
  if (auto refusal = take_permit(applicant)) co_return refusal;
  keep_pending(applicant);
  if (applicant.grant.has(protocol::kFeatureWaiting)) {
    asio::co_spawn(io_, tell_what_it_waits_for(applicant.stream, applicant.grant.scene_name), asio::detached);
  }
  if (auto refusal = co_await await_start(applicant)) co_return refusal;
  if (auto refusal = co_await fetch_scene(applicant)) co_return refusal;
  if (auto refusal = book(applicant)) co_return refusal;
  if (auto refusal = co_await find_room(applicant)) co_return refusal;
  co_return open(applicant);
}

// Determines who the client is and what its Hello is granted.
Admission::Verdict Admission::identify(Applicant& applicant, const protocol::Hello& hello) const {
  applicant.claim.tenant = hello.tenant;
  if (shared_.health.stopping) return refused(RefusalCode::draining, kGoingAway);
  if (shared_.health.draining) return refused(RefusalCode::draining, "the server admits nobody at the moment");
  if (const auto message = check_version(hello)) return refused(*message);
  const auto who =
      daemon::identify(hello, applicant.stream->certificate(), *shared_.tenants.get(), shared_.config.server.mode);
  if (const auto* rejected = std::get_if<Rejected>(&who)) {
    applicant.claim.tenant = rejected->tenant;
    return Refusal{rejected->refused, rejected->fault};
  }
  const auto& identified = std::get<Identified>(who);
  applicant.claim.tenant = shared_.tenants.get()->name(identified.tenant);
  applicant.grant.tenant = identified.tenant;
  const auto from = network_of(applicant.stream->peer());
  if (const auto message = shared_.kept_out.objection(identified.tenant, from, Clock::now()))
    return refused(*message);
  auto granted = check_hello(hello, identified.tenant, shared_.config,
                             [&](const auto& asked) { return shared_.catalog.get()->find(asked); });
  if (const auto* message = std::get_if<protocol::Refused>(&granted)) {
    return refused(with_scenes(*message, *shared_.catalog.get()));
  }
  applicant.grant = std::get<SessionGrant>(std::move(granted));
  applicant.grant.credential = identified.credential;
  applicant.grant.credential.shown = wall_now();
  return std::nullopt;
}

// Hands a stored session to the client that proves it is its own, even if another connection still controls it.
asio::awaitable<Admission::Verdict> Admission::reclaim(Applicant& applicant, const protocol::Resume& resume) {
  applicant.claim.session = resume.session;
  if (shared_.health.stopping) co_return refused(RefusalCode::draining, kGoingAway);
  const auto secret = shared_.store.resumption_secret(resume.session);
  const auto proof = applicant.stream->resumption_proof(resume.session, secret.value_or(protocol::Secret{}));
  if (!proof) co_return refused(RefusalCode::internal, proof.error().message);
  if (!protocol::is_equal(*proof, resume.proof) || !secret)
    co_return refused(RefusalCode::unknown_session, kNoSession);
  keep_pending(applicant);
  const Ask<StoredSession> claim = [&](auto on_answer) {
    shared_.store.claim(resume.session, std::move(on_answer));
  };
  auto claimed = co_await answer_of(io_, claim, applicant.departure.get_token());
  if (!claimed || has_departed(applicant)) co_return departed();
  applicant.stored = std::move(*claimed);
  if (!applicant.stored) co_return refused(RefusalCode::unknown_session, kNoSession);
  applicant.claim.tenant = applicant.stored.record().tenant.data();
  auto granted = grant_of(applicant.stored.record(), *shared_.tenants.get(), shared_.config,
                          [&](const auto& asked) { return shared_.catalog.get()->find(asked); });
  if (const auto* message = std::get_if<protocol::Refused>(&granted)) co_return refused(*message);
  applicant.grant = std::get<SessionGrant>(std::move(granted));
  if (const auto objection = objection_to(applicant.grant, shared_)) {
    applicant.stored.forget();
    co_return refused(RefusalCode::unknown_session, *objection);
  }
  co_return std::nullopt;
}

Admission::Verdict Admission::take_permit(Applicant& applicant) {
  auto permit = shared_.limits.take(applicant.grant.tenant, network_of(applicant.stream->peer()));
  if (const auto* message = std::get_if<protocol::Refused>(&permit)) {
    return without_permit(*message);
  }
  applicant.permit.emplace(std::get<SessionPermit>(std::move(permit)));
  return std::nullopt;
}

// A client may be there before the devices are open.
asio::awaitable<Admission::Verdict> Admission::await_start(const Applicant& applicant) {
  asio::steady_timer timer(io_);
  while (!shared_.health.serving) {
    timer.expires_after(kBetweenLooks);
    co_await timer.async_wait(asio::use_awaitable);
    if (has_departed(applicant)) co_return departed();
  }
  co_return std::nullopt;
}

// Until it is answered or has gone.
asio::awaitable<void> Admission::tell_what_it_waits_for(StreamPtr stream, std::string scene) {
  asio::steady_timer timer(io_);
  for (auto pause = kFirstNews;; pause = kBetweenNews) {
    timer.expires_after(pause);
    co_await timer.async_wait(asio::use_awaitable);
    if (!pending_.is_waiting(stream.get())) co_return;
    stream->send(what_is_waited_for(shared_.health, under_way(shared_.scenes, scene)));
  }
}

asio::awaitable<Admission::Verdict> Admission::fetch_scene(Applicant& applicant) {
  SessionGrant& grant = applicant.grant;
  FetchId request;
  const Ask<Result<SceneForUse>> fetch = [&](auto on_answer) {
    request = shared_.scenes.fetch(grant.scene_name, std::move(on_answer), grant.tenant);
  };
  auto answer = co_await answer_of(io_, fetch, applicant.departure.get_token());
  if (!answer) shared_.scenes.give_up(request);
  if (!answer || has_departed(applicant)) co_return departed();
  Result<SceneForUse>& fetched = *answer;
  if (!fetched) {
    co_return without_scene(fetched.error().message, grant.scene_name, *shared_.catalog.get());
  }
  applicant.scene = std::move(*fetched);
  const scenes::LoadedScene& scene = applicant.scene;
  if (applicant.stored && applicant.stored.record().scene_hash != scene.scene->content_hash) {
    co_return refused(RefusalCode::unknown_session, "the scene is another one now");
  }
  grant.scene = scene.id;
  const auto tenants = shared_.tenants.get();
  const TenantConfig& tenant = tenants->config(grant.tenant);
  complete(grant, scene.scene->lights, {tenant.max_samples, tenant.max_occlusion});
  co_return std::nullopt;
}

// Books the session's demand for the devices' time.
Admission::Verdict Admission::book(Applicant& applicant) const {
  const SessionGrant& grant = applicant.grant;
  const CostModels costs = shared_.devices.costs();
  const auto known = costs.find(grant.scene);
  const bool references =
      grant.has(protocol::kFeatureReferences) &&
      (grant.codec == protocol::CodecId::tiles_context || grant.dense_codec == protocol::CodecId::tiles_context);
  const auto rejection = shared_.limits.book(
      *applicant.permit,
      {grant.width, grant.height, grant.lights, grant.rate_hz, references, grant.area_count(), grant.samples},
      known == costs.end() ? scheduler::CostModel() : known->second.model(grant.samples));
  if (!rejection) return std::nullopt;
  return refused(*rejection);
}

// Asks the devices whether there is memory for the session's frames.
asio::awaitable<Admission::Verdict> Admission::find_room(const Applicant& applicant) {
  const SessionGrant& grant = applicant.grant;
  const Ask<Result<void>> ask = [&](auto on_answer) {
    shared_.devices.ask_room({.scene = grant.scene,
                              .tenant = grant.tenant,
                              .width = grant.width,
                              .height = grant.height,
                              .samples = grant.samples,
                              .answer = std::move(on_answer)});
  };
  const auto answer = co_await answer_of(io_, ask, applicant.departure.get_token());
  if (!answer || has_departed(applicant)) co_return departed();
  const Result<void>& room = *answer;
  if (const auto objection = objection_to(grant, shared_)) {  // a reload may have changed who is welcome
    const bool served = shared_.tenants.get()->open(grant.tenant);
    co_return refused(served ? RefusalCode::bad_token : RefusalCode::unknown_tenant, *objection);
  }
  if (room) co_return std::nullopt;
  Refusal refusal = refused(RefusalCode::over_capacity, "no memory for its frames: " + room.error().message);
  refusal.limit = scheduler::Limit::memory;
  co_return refusal;
}

Admission::Verdict Admission::open(Applicant& applicant) {
  const bool resumed = static_cast<bool>(applicant.stored);
  const SessionId id = resumed ? SessionId{applicant.stored.record().id} : random_session_id();
  auto seal = make_seal(applicant, id);
  if (!seal) return refused(RefusalCode::internal, seal.error().message);
  pending_.remove(applicant.stream.get());
  const Session& session = control_.open({.id = id,
                                          .grant = std::move(applicant.grant),
                                          .seal = std::move(*seal),
                                          .permit = std::move(*applicant.permit),
                                          .stored = std::move(applicant.stored),
                                          .scene_use = std::move(applicant.scene.use)},
                                         applicant.stream);
  applicant.stream->send(
      welcome_of(session, applicant.scene, shared_, {data_port_, applicant.stream->reached().port()}));
  control_.offer_web_transport(session);
  if (shared_.health.draining) control_.ask_to_move(id, true);  // it has missed that while it was away
  const SessionGrant& grant = session.grant();
  log::info(resumed ? "session resumed" : "session opened",
            {{"session", id.value},
             {"tenant", shared_.tenants.get()->name(grant.tenant)},
             {"scene", grant.scene_name},
             {"size", std::to_string(grant.width) + "x" + std::to_string(grant.height)},
             {"address", applicant.stream->peer().to_string()}});
  return std::nullopt;
}

// The seal of a resumed session continues from its record. The seal of a new session is kept in a record if the session
// may be resumed and there is room for a record; otherwise kFeatureResume is withdrawn from the grant.
Result<std::unique_ptr<protocol::Seal>> Admission::make_seal(Applicant& applicant, SessionId id) const {
  SessionGrant& grant = applicant.grant;
  StoredSession& stored = applicant.stored;
  if (stored) {
    ++stored.record().generation;
    return std::make_unique<protocol::Seal>(id, grant.cipher, stored.record().seal, protocol::Side::server);
  }
  const auto secrets = applicant.stream->seal_secrets(id, grant.cipher);
  if (!secrets) return secrets.error();
  if (grant.has(protocol::kFeatureResume)) {
    const auto resumption = applicant.stream->resumption_secret(id);
    if (!resumption) return resumption.error();
    stored = shared_.store.add(record_of(id, grant, shared_.tenants.get()->name(grant.tenant),
                                         {.scene_hash = applicant.scene.scene->content_hash,
                                          .resumption = *resumption,
                                          .seal = protocol::first_state(*secrets, protocol::Side::server)}));
  }
  if (stored)
    return std::make_unique<protocol::Seal>(id, grant.cipher, stored.record().seal, protocol::Side::server);
  grant.features &= ~protocol::kFeatureResume;
  return std::make_unique<protocol::Seal>(id, grant.cipher, *secrets, protocol::Side::server);
}

template <typename OnMessage>
void Admission::listen(const StreamPtr& stream, OnMessage on_message, std::stop_source departure) {
  const std::weak_ptr<ControlStream> weak = stream;  // weak, as the stream owns the callbacks
  stream->listen(
      [weak, on_message](Result<protocol::Message> message) {
        if (const auto from = weak.lock()) on_message(from, std::move(message));
      },
      [this, weak, departure](Fault fault, const std::string& why) {
        const auto from = weak.lock();
        if (from && pending_.remove(from.get()) && !from->is_idle_browser()) {
          shared_.metrics.report(fault, {{"why", why}, {"address", from->peer().to_string()}});
        }
        departure.request_stop();
      });
}

// A client that says Bye before it is answered has given up, which is its right.
void Admission::on_bye(const StreamPtr& stream) {
  if (!pending_.remove(stream.get())) return;
  shared_.metrics.report(Fault::handshake_abandoned,
                         {{"why", "the client said Bye"}, {"address", stream->peer().to_string()}});
  pending_.close_gracefully(stream, Clock::now());
}

// Keeps the connection pending without a deadline, and safe from strangers, while it waits for another thread. A further
// message before the first one is answered is refused, but for a Bye.
void Admission::keep_pending(const Applicant& applicant) {
  pending_.mark_authenticated(applicant.stream.get());
  listen(
      applicant.stream,
      [this, departure = applicant.departure, claim = applicant.claim](const StreamPtr& from,
                                                                       const Result<protocol::Message>& message) {
        if (message && std::holds_alternative<protocol::Bye>(*message)) {
          on_bye(from);
        } else {
          refuse(from, refused(RefusalCode::malformed, "a message before the first one was answered"), claim);
        }
        departure.request_stop();
      },
      applicant.departure);
}

void Admission::refuse(const StreamPtr& stream, const Refusal& refusal, const Claim& claim, TenantId tenant) {
  if (refusal.departed) return;
  report(shared_.metrics, refusal, claim, tenant, stream->peer());
  pending_.remove(stream.get());
  stream->send(refusal.message);
  pending_.close_gracefully(stream, Clock::now());
}

}  // namespace gnomon::daemon
