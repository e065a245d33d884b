#include "tests/eval/remote/remote_server.h"

#include <array>
#include <asio/io_context.hpp>
#include <asio/post.hpp>
#include <asio/steady_timer.hpp>
#include <optional>
#include <thread>

#include "client/view/ground_truth_renderer.h"
#include "common/inbox.h"
#include "daemon/link/link_sender.h"
#include "daemon/net/data_socket.h"
#include "protocol/feedback.h"
#include "tests/eval/remote/unit_stream.h"

namespace gnomon::remote {
namespace {

constexpr uint64_t kFeatures = protocol::kFeatureFeedback | protocol::kFeatureParity;
constexpr double kShareForVideo = 0.85;  // of the link's rate; headers, seals and repeats take their part
constexpr double kLeastBitPerS = 100e3;

struct Order {
  protocol::CameraUpdate update;
  double bit_per_s = 0;
};

}  // namespace

struct RemoteServer::State {
  explicit State(const ServerOptions& o)
      : options(o),
        seal(kSession, protocol::CipherId::aes_128_gcm, o.secrets, protocol::Side::server),
        link(kFeatures),
        timer(io) {}

  // The link's thread.
  void receive(std::span<const uint8_t> datagram, const asio::ip::udp::endpoint& from);
  void take(const protocol::CameraUpdate& update, TimePoint now);
  void order_next(TimePoint now);
  void send(const Unit& unit);
  void pump();
  void wake(TimePoint when);
  double video_rate() const;

  // The renderer's.
  void render_orders();
  Result<Unit> render(const Order& order);

  ServerOptions options;
  asio::io_context io;
  std::unique_ptr<daemon::DataSocket> socket;
  protocol::Seal seal;
  daemon::LinkSender link;
  asio::steady_timer timer;
  std::optional<asio::ip::udp::endpoint> client;
  std::optional<protocol::CameraUpdate> waiting;  // the newest camera that was not rendered
  FrameId newest;
  bool rendering = false;
  double interval_s = 0;  // between units, smoothed
  TimePoint last_unit{};
  std::array<std::vector<uint8_t>, 1> datagram;

  Inbox<Order> orders;
  std::unique_ptr<client::GroundTruthRenderer> source;
  std::optional<H264Encoder> encoder;
  uint32_t units = 0;
  uint32_t repair_wanted_at = 0;  // the last key unit's number

  ServerFigures figures;  // render, encode and counts of units: the renderer's; bytes: the link's
  std::optional<Error> failure;
  std::thread link_thread, render_thread;
};

RemoteServer::RemoteServer(std::unique_ptr<State> state) : state_(std::move(state)) {}

RemoteServer::~RemoteServer() { (void)stop(); }

uint16_t RemoteServer::port() const { return state_->socket->port(); }

Result<std::unique_ptr<RemoteServer>> RemoteServer::start(const ServerOptions& options) {
  auto state = std::make_unique<State>(options);
  auto source = client::GroundTruthRenderer::create(options.scene, {options.video.width, options.video.height},
                                                    {.device = options.device}, options.cache);
  if (!source) return source.error();
  state->source = std::move(*source);
  if (auto first = state->source->picture(options.first); !first) return first.error();
  auto encoder = H264Encoder::create(options.video);
  if (!encoder) return encoder.error();
  state->encoder = std::move(*encoder);
  auto socket = daemon::DataSocket::open(state->io, {asio::ip::make_address("127.0.0.1"), 0});
  if (!socket) return socket.error();
  state->socket = std::move(*socket);
  State* s = state.get();
  s->socket->start([s](auto datagram, const auto& from) { s->receive(datagram, from); });
  s->render_thread = std::thread([s] { s->render_orders(); });
  s->link_thread = std::thread([s] { s->io.run(); });
  return std::unique_ptr<RemoteServer>(new RemoteServer(std::move(state)));
}

Result<ServerFigures> RemoteServer::stop() {
  State& s = *state_;
  if (s.link_thread.joinable()) {
    s.orders.close();
    s.render_thread.join();
    s.io.stop();
    s.link_thread.join();
  }
  if (s.failure) return *s.failure;
  return s.figures;
}

void RemoteServer::State::receive(std::span<const uint8_t> bytes, const asio::ip::udp::endpoint& from) {
  const auto opened = seal.open(bytes);
  if (!opened) return;
  client = from;
  const TimePoint now = Clock::now();
  if (opened->header.kind == protocol::DatagramKind::feedback) {
    if (const auto feedback = protocol::decode_feedback(opened->body)) link.on_feedback(*feedback, now);
  }
  if (opened->header.kind == protocol::DatagramKind::camera_update) {
    if (const auto update = protocol::decode_camera_update(opened->body)) take(*update, now);
  }
  pump();
}

void RemoteServer::State::take(const protocol::CameraUpdate& update, TimePoint now) {
  if (update.frame <= newest) return;
  newest = update.frame;
  waiting = update;
  order_next(now);
}

void RemoteServer::State::order_next(TimePoint now) {
  if (!waiting || rendering || !link.may_request(now)) return;
  link.on_request(waiting->frame, now);
  rendering = true;
  orders.push({*std::exchange(waiting, std::nullopt), video_rate()});
}

// The encoder spreads its rate over the pictures of a second at full speed; fewer may have more bytes each.
double RemoteServer::State::video_rate() const {
  const double slower = interval_s > 0 ? std::max(1.0, interval_s * options.video.fps) : 1;
  const double found = std::max(kLeastBitPerS, 8 * link.rate() * kShareForVideo);
  const double allowed = options.most_bit_per_s > 0 ? std::min(found, options.most_bit_per_s) : found;
  return allowed * slower;
}

void RemoteServer::State::send(const Unit& unit) {
  const TimePoint now = Clock::now();
  rendering = false;
  if (last_unit != TimePoint{}) {
    const double interval = to_seconds(now - last_unit);
    interval_s += (interval - interval_s) / (interval_s == 0 ? 1 : 8);
  }
  last_unit = now;
  link.add(to_slices(unit, link.slice_body_bytes() - protocol::kSliceHeaderBytes), TimePoint::max(), now);
  pump();
}

void RemoteServer::State::pump() {
  const TimePoint now = Clock::now();
  while (const auto out = link.next(now)) {
    const uint64_t sequence = seal.seal(out->kind, out->body, datagram[0]);
    link.sent(sequence, datagram[0].size(), now);
    figures.datagram_bytes += datagram[0].size();
    asio::error_code lost_as_on_any_link;
    if (client) socket->send(datagram, *client, lost_as_on_any_link);
  }
  order_next(now);
  TimePoint next = link.wake_at(now);
  if (waiting && !rendering) next = std::min(next, link.may_request_at(now));
  wake(next);
}

void RemoteServer::State::wake(TimePoint when) {
  if (when == TimePoint::max()) return;
  timer.expires_at(when);
  timer.async_wait([this](const asio::error_code& error) {
    if (!error) pump();
  });
}

void RemoteServer::State::render_orders() {
  std::vector<Order> batch;
  for (orders.take(batch); !batch.empty(); orders.take(batch)) {
    auto unit = render(batch.back());
    if (!unit) {
      failure = unit.error();
      return;
    }
    asio::post(io, [this, made = std::move(*unit)] { send(made); });
  }
}

// A client that has lost pictures says that it has none; it gets a key picture, once until that had time to arrive.
Result<Unit> RemoteServer::State::render(const Order& order) {
  const TimePoint begun = Clock::now();
  auto picture = source->picture(order.update.camera);
  if (!picture) return picture.error();
  const TimePoint rendered = Clock::now();
  Unit unit{order.update.frame, ++units, false, {}};
  const bool has_none = order.update.have.value == 0;
  unit.key = units == 1 || (has_none && units > repair_wanted_at + UnitAssembler::kPatience);
  if (unit.key) repair_wanted_at = units;
  encoder->set_rate(order.bit_per_s);
  auto bytes = encoder->encode(*picture, unit.key);
  if (!bytes) return bytes.error();
  unit.bytes = std::move(*bytes);
  figures.render.add(rendered - begun);
  figures.encode.add(Clock::now() - rendered);
  ++figures.units;
  figures.key_units += unit.key;
  figures.video_bytes += unit.bytes.size();
  return unit;
}

}  // namespace gnomon::remote
