#include "client/connection.h"

#include <array>
#include <cstdio>
#include <utility>

namespace gnomon::client {

std::string describe(const protocol::Refused& refused) {
  std::string line = std::string("refused (") + protocol::to_string(refused.code) + "): " + refused.text;
  std::string fit;
  if (refused.fit_width && refused.fit_height) {
    fit = std::to_string(refused.fit_width) + "x" + std::to_string(refused.fit_height);
  }
  if (refused.fit_rate_hz > 0) {
    char rate[32];
    std::snprintf(rate, sizeof rate, "%.4g Hz", static_cast<double>(refused.fit_rate_hz));
    fit.append(fit.empty() ? "" : " at ").append(rate);
  }
  if (!fit.empty()) line.append("; would fit: ").append(fit);
  return line;
}

namespace {

protocol::Hello with_ciphers(protocol::Hello hello) {
  using enum protocol::CipherId;
  if (!hello.ciphers.empty()) return hello;
  hello.ciphers = {aes_128_gcm, chacha20_poly1305};
  if (!protocol::has_aes_instructions()) std::swap(hello.ciphers[0], hello.ciphers[1]);
  return hello;
}

}  // namespace

Connection::Connection(Loop& loop, ConnectOptions options, ConnectionEvents events)
    : loop_(loop),
      options_(std::move(options)),
      events_(std::move(events)),
      path_(options_.transport),
      handshake_timer_(
          loop, [this] { fail(Error{std::string("no answer from ") + to_string(options_.server) + " in time"}); }),
      path_timer_(loop, [this] { watch_path(); }),
      control_(loop, options_.server, options_.trust,
               {.connected = [this] { control_.send(with_ciphers(options_.hello)); },
                .message = [this](protocol::Message message) { on_message(std::move(message)); },
                .failed = [this](const Error& error) { fail(error); }}) {
  handshake_timer_.arm(Clock::now() + options_.timeout);
}

Connection::~Connection() { close(""); }

Result<void> Connection::wait_open() {
  loop_.run_until(TimePoint::max(), [this] { return state_ != State::connecting; });
  if (state_ == State::open) return {};
  return failure_.value_or(Error{"the connection was closed"});
}

DataCounters Connection::data_counters() const {
  DataCounters sum = by_control_;
  if (data_) {
    sum.sent += data_->counters().sent;
    sum.received += data_->counters().received;
    sum.received_bytes += data_->counters().received_bytes;
    sum.rejected += data_->counters().rejected;
  }
  return sum;
}

void Connection::send(protocol::DatagramKind kind, std::span<const uint8_t> body) {
  if (state_ != State::open) return;
  if (path_.by_udp()) return data_->send(kind, body);
  ++by_control_.sent;
  control_.send(protocol::Data{kind, ++sent_by_control_, {body.begin(), body.end()}});
}

void Connection::watch_path() {
  if (state_ != State::open) return;
  static constexpr std::array<uint8_t, protocol::kPingBytes> kZeros{};
  if (path_.ping_due(Clock::now())) data_->send(protocol::DatagramKind::ping, kZeros);
  path_timer_.arm(Clock::now() + PathWatch::kInterval);
}

void Connection::on_data(const protocol::Data& data) {
  ++by_control_.received;
  by_control_.received_bytes += protocol::Seal::sealed_size(data.body.size());
  const protocol::Header header{data.kind, 0, welcome_.session, data.sequence};
  if (events_.datagram) events_.datagram({header, data.body}, Clock::now());
}

void Connection::close(const std::string& reason) {
  if (state_ == State::closed) return;
  state_ = State::closed;
  handshake_timer_.disarm();
  path_timer_.disarm();
  control_.close(reason);
}

void Connection::on_message(protocol::Message message) {
  if (state_ == State::closed) return;
  if (const auto* bye = std::get_if<protocol::Bye>(&message)) {
    return fail(Error{"the server ended the session" +
                      (bye->reason.empty() ? std::string() : std::string(": ") + bye->reason)});
  }
  if (state_ == State::open) {
    if (const auto* data = std::get_if<protocol::Data>(&message)) return on_data(*data);
    if (events_.message) events_.message(message);
    return;
  }
  if (auto* welcome = std::get_if<protocol::Welcome>(&message)) return on_welcome(std::move(*welcome));
  if (auto* refused = std::get_if<protocol::Refused>(&message)) {
    refusal_ = std::move(*refused);
    return fail(Error{describe(*refusal_)});
  }
  fail(Error{"the server answered Hello with neither Welcome nor Refused"});
}

void Connection::on_welcome(protocol::Welcome welcome) {
  // The masks' memory is sized by these numbers: never beyond what was asked for.
  if (welcome.width == 0 || welcome.height == 0 || welcome.width > options_.hello.width ||
      welcome.height > options_.hello.height || welcome.scene.lights.size() > protocol::kMaxLights) {
    return fail(Error{"the server's Welcome offers a size or a number of lights that was not asked for"});
  }
  const auto secrets = control_.seal_secrets(welcome.session, welcome.cipher);
  if (!secrets) return fail(secrets.error());
  auto seal = std::make_unique<protocol::Seal>(welcome.session, welcome.cipher, *secrets, protocol::Side::client);
  auto data = DataChannel::open(loop_, {control_.server_ip(), welcome.data_port}, std::move(seal),
                                [this](const protocol::Opened& datagram, TimePoint arrived) {
                                  path_.heard(Clock::now());
                                  if (state_ == State::open && events_.datagram)
                                    events_.datagram(datagram, arrived);
                                });
  if (!data) return fail(data.error());
  welcome_ = std::move(welcome);
  data_ = std::move(*data);
  handshake_timer_.disarm();
  state_ = State::open;
  watch_path();
  if (events_.opened) events_.opened();
}

void Connection::fail(Error error) {
  if (state_ == State::closed) return;
  close("");
  failure_ = std::move(error);
  if (events_.closed) events_.closed(*failure_);
}

}  // namespace gnomon::client
