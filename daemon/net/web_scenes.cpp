#include "daemon/net/web_scenes.h"

#include <asio/steady_timer.hpp>
#include <asio/use_awaitable.hpp>

#include "daemon/net/admission_refusal.h"
#include "daemon/net/answer.h"
#include "daemon/net/words_for_clients.h"
#include "daemon/session/credentials.h"

namespace gnomon::daemon {
namespace {

using protocol::RefusalCode;

int status_of(RefusalCode code) {
  switch (code) {
    case RefusalCode::bad_token:
    case RefusalCode::unknown_tenant: return 401;
    case RefusalCode::kept_out: return 403;
    case RefusalCode::unknown_scene: return 404;
    case RefusalCode::version:
    case RefusalCode::bad_size:
    case RefusalCode::unknown_pass:
    case RefusalCode::malformed:
    case RefusalCode::too_many_sessions:
    case RefusalCode::draining:
    case RefusalCode::over_capacity:
    case RefusalCode::scene_unavailable:
    case RefusalCode::unknown_session:
    case RefusalCode::internal: break;
  }
  return 503;
}

// Counted and logged as the refusal of a Hello is. Who may not be here guesses once a connection, as with a Hello.
web::Response refuse(const NetShared& shared, const AdmissionRefusal& refusal, const AdmissionClaim& claim,
                     const ControlStream& stream, TenantId tenant = {}) {
  report(shared.metrics, refusal, claim, tenant, stream.peer());
  web::Response response = web::text_response(status_of(refusal.message.code), refusal.message.text);
  response.close = response.status == 401 || response.status == 403;
  if (response.status == 401) response.fields.emplace_back("WWW-Authenticate", "Bearer");
  return response;
}

// What Admission::identify determines from a Hello.
std::variant<TenantId, AdmissionRefusal> identify(const NetShared& shared, const web::Request& request,
                                                  ControlStream& stream, AdmissionClaim& claim) {
  claim.tenant = request.tenant;
  if (shared.health.stopping || shared.health.draining) {
    return refused(RefusalCode::draining, "the server admits nobody at the moment");
  }
  protocol::Hello hello;
  hello.tenant = request.tenant;
  hello.token = web::bearer_token(request.authorization);
  const auto who = daemon::identify(hello, stream.certificate(), *shared.tenants.get(), shared.config.server.mode);
  if (const auto* rejected = std::get_if<Rejected>(&who)) {
    claim.tenant = rejected->tenant;
    return AdmissionRefusal{rejected->refused, rejected->fault};
  }
  const TenantId tenant = std::get<Identified>(who).tenant;
  claim.tenant = shared.tenants.get()->name(tenant);
  if (const auto message = shared.kept_out.objection(tenant, network_of(stream.peer()), Clock::now())) {
    return refused(*message);
  }
  return tenant;
}

std::vector<std::string> names_in(const SceneCatalog& catalog) {
  std::vector<std::string> names;
  for (const auto& source : catalog.sources()) names.push_back(source.name);
  return names;
}

}  // namespace

asio::awaitable<std::optional<web::Response>> answer_about_scene(const NetShared& shared, asio::io_context& io,
                                                                 std::shared_ptr<ControlStream> stream,
                                                                 web::Request request, web::SceneTarget target,
                                                                 std::stop_token departure) {
  AdmissionClaim claim;
  const auto who = identify(shared, request, *stream, claim);
  if (const auto* refusal = std::get_if<AdmissionRefusal>(&who)) co_return refuse(shared, *refusal, claim, *stream);
  const TenantId tenant = std::get<TenantId>(who);
  if (target.name.empty()) co_return web::scene_list(names_in(*shared.catalog.get()));
  const std::string name = shared.catalog.get()->find(target.name);
  if (name.empty())
    co_return refuse(shared, refused(RefusalCode::unknown_scene, "there is no such scene"), claim, *stream);
  const auto permit = shared.limits.take(tenant, network_of(stream->peer()));
  if (const auto* message = std::get_if<protocol::Refused>(&permit)) {
    co_return refuse(shared, without_permit(*message), claim, *stream, tenant);
  }
  asio::steady_timer timer(io);
  while (!shared.health.serving) {
    timer.expires_after(kBetweenLooks);
    co_await timer.async_wait(asio::use_awaitable);
    if (departure.stop_requested()) co_return std::nullopt;
  }
  FetchId fetch_id;
  const Ask<Result<SceneForUse>> fetch = [&](auto on_answer) {
    fetch_id = shared.scenes.fetch(name, std::move(on_answer), tenant);
  };
  auto scene = co_await answer_of(io, fetch, departure);
  if (!scene) shared.scenes.give_up(fetch_id);
  if (!scene) co_return std::nullopt;
  if (!*scene) {
    co_return refuse(shared, without_scene(scene->error().message, name, *shared.catalog.get()), claim, *stream);
  }
  ScenePacks::WaitId wait;
  const Ask<Result<ScenePackPtr>> make = [&](auto on_answer) {
    wait = shared.packs->get(name, std::move(**scene), tenant, std::move(on_answer));
  };
  const auto made = co_await answer_of(io, make, departure);
  if (!made) shared.packs->give_up(wait);
  if (!made) co_return std::nullopt;
  if (!*made)
    co_return refuse(shared, refused(RefusalCode::scene_unavailable, made->error().message), claim, *stream);
  const ScenePack& pack = ***made;
  if (target.sha256.empty()) co_return web::scene_page(target.name, pack.sha256, pack.bytes);
  if (target.sha256 != pack.sha256) co_return web::text_response(404, "the scene is another one now");
  co_return web::pack_response(request, pack.packed);
}

}  // namespace gnomon::daemon
