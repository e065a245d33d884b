// How a connection becomes a session and how a session ends.
#include <asio/post.hpp>

#include "daemon/credentials.h"
#include "daemon/net_thread.h"
#include "daemon/random_bytes.h"
#include "daemon/translate.h"

namespace gnomon::daemon {
namespace {

using protocol::RefusalCode;
using namespace std::chrono_literals;

constexpr auto kShowOutTime = 1s;  // for a client to read our last words and close

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
  const auto* hello = std::get_if<protocol::Hello>(&*message);
  if (!hello) return refuse(stream, refusal(RefusalCode::malformed, "the first message must be a Hello"));
  admit(stream, *hello);
}

void NetThread::admit(const std::shared_ptr<ControlStream>& stream, const protocol::Hello& hello) {
  if (shared_.health.draining) return refuse(stream, refusal(RefusalCode::draining, "the server is going away"));
  if (const auto refused = check_version(hello)) return refuse(stream, *refused);
  const auto who = identify(hello, stream->certificate_names(), *shared_.roster.get(), shared_.config.server.mode);
  if (const auto* rejected = std::get_if<Rejected>(&who)) return refuse(stream, rejected->refused, rejected->fault);
  auto verdict = check_hello(hello, std::get<TenantId>(who), shared_.config,
                             [&](const auto& asked) { return shared_.catalog.find(asked); });
  if (const auto* refused = std::get_if<protocol::Refused>(&verdict)) return refuse(stream, *refused);
  const Accepted& accepted = std::get<Accepted>(verdict);
  auto seat = shared_.seats.take(accepted.tenant, stream->peer());
  if (const auto* refused = std::get_if<protocol::Refused>(&seat)) {
    shared_.metrics.refused(accepted.tenant, to_string(scheduler::Limit::sessions));
    return refuse(stream, *refused);
  }

  // While the scene is brought the connection holds its seat; should it end, nobody waits for the answer.
  lobby_.remove(stream.get());
  lobby_.enter({stream, TimePoint::max()});
  watch_visitor(stream, [this](const auto& visitor, Result<protocol::Message>) {
    refuse(visitor, refusal(RefusalCode::malformed, "a message before the Hello was answered"));
  });
  auto kept_seat = std::make_shared<Seat>(std::move(std::get<Seat>(seat)));
  const std::weak_ptr<ControlStream> weak = stream;
  shared_.scenes.fetch(accepted.scene, [this, weak, accepted, kept_seat](Result<SceneForUse> scene) {
    asio::post(io_, [this, weak, accepted = Accepted(accepted), kept_seat, scene = std::move(scene)]() mutable {
      const auto waiting = weak.lock();
      if (!waiting || !lobby_.hosts(waiting.get())) return;
      if (!scene) return refuse(waiting, refusal(RefusalCode::scene_unavailable, scene.error().message));
      accepted.scene_use = scene->use;
      if (book(waiting, accepted, *kept_seat, *scene)) open_if_room(waiting, accepted, kept_seat, *scene);
    });
  });
}

// False: refused.
bool NetThread::book(const std::shared_ptr<ControlStream>& stream, const Accepted& accepted, Seat& seat,
                     const scenes::LoadedScene& scene) {
  const CostModels costs = shared_.devices.costs();
  const auto known = costs.find(scene.id);
  const auto lights = static_cast<uint32_t>(scene.scene->lights.size());
  const auto misfit = shared_.seats.book(seat, {accepted.width, accepted.height, lights, accepted.rate_hz},
                                         known == costs.end() ? scheduler::CostModel() : known->second);
  if (!misfit) return true;
  shared_.metrics.refused(accepted.tenant, to_string(misfit->limit));
  refuse(stream, refusal_of(*misfit));
  return false;
}

// As for the scene, the connection waits for the devices' answer.
void NetThread::open_if_room(const std::shared_ptr<ControlStream>& stream, const Accepted& accepted,
                             const std::shared_ptr<Seat>& seat, const scenes::LoadedScene& scene) {
  const auto decide = [this, weak = std::weak_ptr(stream), accepted, seat, scene](const Result<void>& room) {
    const auto waiting = weak.lock();
    if (!waiting || !lobby_.hosts(waiting.get())) return;
    if (!shared_.roster.get()->open(accepted.tenant)) {
      return refuse(waiting, refusal(RefusalCode::unknown_tenant, "the tenant is no longer served"));
    }
    if (room) return open_session(waiting, accepted, std::move(*seat), scene);
    shared_.metrics.refused(accepted.tenant, to_string(scheduler::Limit::memory));
    refuse(waiting, refusal(RefusalCode::over_capacity, "no memory for its frames: " + room.error().message));
  };
  shared_.devices.ask_room(
      {scene.id, accepted.tenant, accepted.width, accepted.height,
       [this, decide](Result<void> room) { asio::post(io_, [decide, room = std::move(room)] { decide(room); }); }});
}

void NetThread::open_session(const std::shared_ptr<ControlStream>& stream, const Accepted& accepted, Seat seat,
                             const scenes::LoadedScene& scene) {
  const SessionId id = random_session_id();
  const auto secrets = stream->seal_secrets(id, accepted.cipher);
  if (!secrets) return refuse(stream, refusal(RefusalCode::internal, secrets.error().message));
  auto seal = std::make_unique<protocol::Seal>(id, accepted.cipher, *secrets, protocol::Side::server);
  sessions_.add(std::make_unique<Session>(id, std::move(seal), accepted, std::move(seat), Clock::now()));
  lobby_.remove(stream.get());
  streams_.emplace(id, stream);
  stream->listen([this, id](Result<protocol::Message> message) { hear_client(id, std::move(message)); },
                 [this, id](Fault, const std::string& why) { close_session(id, why); });
  const auto lights = static_cast<uint32_t>(scene.scene->lights.size());
  shared_.devices.open({id, accepted.tenant, scene.id, accepted.width, accepted.height, lights, accepted.codec,
                        index_, accepted.rate_hz, (accepted.features & protocol::kFeatureMoments) != 0,
                        accepted.dense_codec, sessions_.find(id)->references()});
  shared_.metrics.session_opened(accepted.tenant);

  protocol::Welcome welcome;
  welcome.session = id;
  welcome.data_port = data_->port();
  welcome.cipher = accepted.cipher;
  welcome.width = accepted.width;
  welcome.height = accepted.height;
  welcome.rate_hz = accepted.rate_hz;
  welcome.codec = accepted.codec;
  welcome.passes = shared_.config.render.passes;
  welcome.tracer = shared_.tracer;
  welcome.silence_timeout_ms = static_cast<uint32_t>(shared_.config.server.silence_timeout.count());
  welcome.scene = manifest_of(*scene.scene, accepted.scene, float(accepted.width) / float(accepted.height));
  const LightsNews news = shared_.scenes.lights_of(accepted.scene);
  welcome.features = accepted.features;
  welcome.scene.lights = to_wire(news.lights);
  welcome.lights_version = news.version;
  welcome.motions = to_wire(shared_.catalog.motions(accepted.scene));
  stream->send(welcome);
  log::info("session opened", {{"session", id.value},
                               {"tenant", shared_.roster.get()->name(accepted.tenant)},
                               {"scene", accepted.scene},
                               {"size", std::to_string(accepted.width) + "x" + std::to_string(accepted.height)},
                               {"address", stream->peer().to_string()}});
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

void NetThread::hear_client(SessionId id, Result<protocol::Message> message) {
  if (!message) return close_session(id, message.error().message);
  if (std::holds_alternative<protocol::Bye>(*message)) return close_session(id, "the client said Bye");
  if (const auto* data = std::get_if<protocol::Data>(&*message)) return hear_data(id, *data);
  close_session(id, "the client sent a message that only servers send");
}

void NetThread::close_session(SessionId id, const std::string& why) {
  const auto found = streams_.find(id);
  if (found == streams_.end()) return;
  const std::shared_ptr<ControlStream> stream = found->second;
  const Session& session = *sessions_.find(id);
  const protocol::Stats totals = sessions_.find(id)->take_stats();
  log::info("session closed", {{"session", id.value},
                               {"tenant", shared_.roster.get()->name(session.accepted().tenant)},
                               {"why", why},
                               {"frames", totals.frames},
                               {"coalesced", totals.coalesced}});
  shared_.metrics.session_closed(session.accepted().tenant);
  shared_.devices.close(id);
  shared_.metrics.link(sessions_.find(id)->take_link_report());
  wakes_.remove(id);
  sessions_.remove(id);
  streams_.erase(found);
  stream->send(protocol::Bye{why});
  show_out(stream);
}

void NetThread::show_out(const std::shared_ptr<ControlStream>& stream) {
  stream->finish();
  for (const Visitor& pushed_out : lobby_.enter({stream, Clock::now() + kShowOutTime, true})) {
    pushed_out.stream->close();
  }
}

}  // namespace gnomon::daemon
