#include "client/net/connection.h"

#include <array>
#include <asio/ip/address.hpp>
#include <cstdio>
#include <utility>

#include "common/printable.h"
#include "common/sample_counts.h"

namespace gnomon::client {

std::string describe(const protocol::Refused& refused) {
  std::string line =
      std::string("refused (") + protocol::to_string(refused.code) + "): " + without_controls(refused.text);
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

constexpr Nanoseconds kTryAgain = std::chrono::milliseconds(100);
constexpr Nanoseconds kControlSilence = std::chrono::seconds(4);  // Stats come about once a second

protocol::Hello completed(protocol::Hello hello) {
  using enum protocol::CipherId;
  hello.features |=
      protocol::kFeatureResume | protocol::kFeaturePaths | protocol::kFeatureWaiting | protocol::kFeatureFleet;
  if (!hello.ciphers.empty()) return hello;
  hello.ciphers = {aes_128_gcm, chacha20_poly1305};
  if (!protocol::has_aes_instructions()) std::swap(hello.ciphers[0], hello.ciphers[1]);
  return hello;
}

Error end_told_by(const protocol::Bye& bye) {
  std::string why = "the server ended the session";
  if (!bye.reason.empty()) why.append(": ").append(without_controls(bye.reason));
  if (bye.stay_out_ms > 0) {
    const uint64_t seconds = (uint64_t{bye.stay_out_ms} + 999) / 1000;
    why.append("; it keeps this client out for ").append(std::to_string(seconds)).append(" s");
  }
  return Error{why};
}

protocol::Refused kept_out_by(const protocol::Bye& bye) {
  protocol::Refused refused;
  refused.code = protocol::RefusalCode::kept_out;
  refused.text = bye.reason;
  return refused;
}

bool is_numeric(const std::string& host) {
  asio::error_code error;
  asio::ip::make_address(host, error);
  return !error;
}

// Names are not looked up: who answers for them could send the session's datagrams anywhere.
bool names_addresses(const protocol::Welcome& welcome) {
  if ((welcome.features & protocol::kFeatureFleet) == 0) return true;
  return is_numeric(welcome.data_host) && is_numeric(welcome.home_host);
}

// Its numbers determine the masks' memory, so they must not exceed what was asked for. nullopt: it may be used.
std::optional<Error> objection_to(const protocol::Welcome& welcome, const protocol::Hello& asked) {
  if (!names_addresses(welcome)) return Error{"the server's Welcome names a host by no address"};
  if ((welcome.features & ~completed(asked).features) != 0) {
    return Error{"the server's Welcome grants features that were not asked for"};
  }
  const SampleCounts granted = sample_counts_of(welcome.samples), most = sample_counts_of(asked.samples);
  if (fewest(granted, most) != granted) {
    return Error{"the server's Welcome grants more samples than were asked for"};
  }
  if (welcome.width > 0 && welcome.height > 0 && welcome.width <= asked.width && welcome.height <= asked.height &&
      welcome.scene.lights.size() <= protocol::kMaxLights) {
    return std::nullopt;
  }
  return Error{"the server's Welcome offers a size or a number of lights that was not asked for"};
}

void ping(DataChannel& data) {
  static constexpr std::array<uint8_t, protocol::kPingBytes> kZeros{};
  data.send(protocol::DatagramKind::ping, kZeros);
}

}  // namespace

Connection::Connection(Loop& loop, ConnectOptions options, ConnectionEvents events)
    : loop_(loop),
      options_(std::move(options)),
      events_(std::move(events)),
      path_(options_.transport),
      route_(options_.server, !options_.trust.fleet.empty()),
      handshake_timer_(
          loop, [this] { fail(Error{std::string("no answer from ") + to_string(options_.server) + " in time"}); }),
      path_timer_(loop, [this] { watch_path(); }),
      resume_timer_(loop, [this] { connect_again(); }) {
  connect(options_.server);
  handshake_timer_.arm(Clock::now() + options_.timeout);
}

void Connection::connect(const Address& where) {
  const auto greet = [this] {
    state_ == State::open ? ask_to_resume() : control_->send(completed(options_.hello));
  };
  control_ =
      std::make_unique<ControlChannel>(loop_, where, options_.trust, options_.hello.scene, control_events(greet));
}

ControlChannel::Events Connection::control_events(std::function<void()> connected) {
  return {.connected = std::move(connected),
          .message = [this](protocol::Message message) { on_message(std::move(message)); },
          .failed = [this](const Error& error) { on_control_lost(error); }};
}

Connection::~Connection() {
  close("");
  protocol::wipe(resumption_.data(), resumption_.size());
}

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
  if (lost_) return;
  ++by_control_.sent;
  control_->send(protocol::Data{kind, ++sent_by_control_, {body.begin(), body.end()}});
}

void Connection::on_datagram(const protocol::Opened& datagram, TimePoint arrived) {
  path_.heard(Clock::now());
  if (datagram.header.kind == protocol::DatagramKind::path_challenge &&
      protocol::decode_path_token(datagram.body)) {
    data_->send(protocol::DatagramKind::path_response, datagram.body.first(protocol::kPathTokenBytes));
  }
  if (state_ == State::open && events_.datagram) events_.datagram(datagram, arrived);
}

void Connection::watch_path() {
  if (state_ != State::open) return;
  if (!lost_ && path_.ping_due(Clock::now())) ping(*data_);
  const bool resumable = (welcome_.features & protocol::kFeatureResume) != 0;
  if (!lost_ && resumable && Clock::now() - control_heard_ > kControlSilence) {
    lose_control(Error{"the server says nothing any more"});
  }
  path_timer_.arm(Clock::now() + PathWatch::kInterval);
}

void Connection::on_data(const protocol::Data& data) {
  ++by_control_.received;
  by_control_.received_bytes += protocol::Seal::sealed_size(data.body.size());
  data_->passed(data.sequence);
  const protocol::Header header{data.kind, 0, welcome_.session, data.sequence};
  if (events_.datagram) events_.datagram({header, data.body}, Clock::now());
}

void Connection::close(const std::string& reason) {
  if (state_ == State::closed) return;
  state_ = State::closed;
  handshake_timer_.disarm();
  path_timer_.disarm();
  resume_timer_.disarm();
  control_->close(reason);
}

void Connection::on_message(protocol::Message message) {
  if (state_ == State::closed) return;
  control_heard_ = Clock::now();
  if (const auto* bye = std::get_if<protocol::Bye>(&message)) {
    if (bye->stay_out_ms > 0) refusal_ = kept_out_by(*bye);
    return fail(end_told_by(*bye));
  }
  if (lost_ && !asked_to_resume_) return;  // from a connection already given up
  if (std::holds_alternative<protocol::Waiting>(message)) {
    if (state_ == State::open && !lost_) return;
    handshake_timer_.arm(std::max(resume_until_, Clock::now() + options_.timeout));
    if (events_.message) events_.message(message);
    return;
  }
  if (lost_) {
    auto* welcome = std::get_if<protocol::Welcome>(&message);
    if (welcome && welcome->session == welcome_.session) return on_resumed(std::move(*welcome));
    return fail(*lost_);  // the server no longer knows the session, or has no room for it
  }
  if (state_ == State::open) {
    if (const auto* data = std::get_if<protocol::Data>(&message)) return on_data(*data);
    if (events_.message) events_.message(message);
    return;
  }
  if (auto* welcome = std::get_if<protocol::Welcome>(&message)) return on_welcome(std::move(*welcome));
  if (auto* refused = std::get_if<protocol::Refused>(&message)) {
    if (const auto wait = route_.ask_door_again(refused->code)) {
      control_->close("");
      handshake_timer_.arm(Clock::now() + *wait + options_.timeout);
      return resume_timer_.arm(Clock::now() + *wait);
    }
    refusal_ = std::move(*refused);
    return fail(Error{describe(*refusal_)});
  }
  fail(Error{"the server answered Hello with neither Welcome nor Refused"});
}

void Connection::on_welcome(protocol::Welcome welcome) {
  if (const auto wrong = objection_to(welcome, options_.hello)) return fail(*wrong);
  const auto secrets = control_->seal_secrets(welcome.session, welcome.cipher);
  if (!secrets) return fail(secrets.error());
  const auto resumption = control_->resumption_secret(welcome.session);
  if (!resumption) return fail(resumption.error());
  auto seal = std::make_unique<protocol::Seal>(welcome.session, welcome.cipher, *secrets, protocol::Side::client);
  auto data = DataChannel::open(
      loop_, FleetRoute::data_address(welcome, control_->server_ip()), std::move(seal),
      [this](const protocol::Opened& datagram, TimePoint arrived) { on_datagram(datagram, arrived); });
  if (!data) return fail(data.error());
  welcome_ = std::move(welcome);
  route_.welcomed(welcome_);
  control_heard_ = Clock::now();
  resumption_ = *resumption;
  data_ = std::move(*data);
  handshake_timer_.disarm();
  state_ = State::open;
  watch_path();
  // The server challenges the address of a first Ping at once, so that it is validated by the time that the first frame
  // is ready. Without a choice of transport none is sent above.
  if ((welcome_.features & protocol::kFeaturePaths) != 0 && options_.transport == Transport::udp) ping(*data_);
  if (events_.opened) events_.opened();
}

// A server that granted the feature resume keeps the session for silence_timeout_ms; datagrams continue meanwhile, and
// the control connection is replaced.
void Connection::on_control_lost(const Error& error) {
  if (state_ != State::open || !(welcome_.features & protocol::kFeatureResume)) return fail(error);
  asked_to_resume_ = false;
  if (!lost_) return lose_control(error);
  if (Clock::now() >= resume_until_) return fail(*lost_);
  resume_timer_.arm(Clock::now() + kTryAgain);
}

void Connection::lose_control(const Error& error) {
  const TimePoint now = Clock::now();
  lost_ = error;
  resume_until_ = now + std::chrono::milliseconds(welcome_.silence_timeout_ms);
  resume_timer_.arm(std::max(now, resumed_ + kTryAgain));
  handshake_timer_.arm(std::max(resume_until_, now + options_.timeout));
}

// Replaces an attempt that has not succeeded in time, as its packets may have been lost.
void Connection::connect_again() {
  if (state_ == State::connecting) return connect(options_.server);  // after the refusal of a fleet's server
  if (state_ == State::closed) return;
  asked_to_resume_ = false;
  const FleetRoute::Attempt attempt = route_.to_resume();
  connect(attempt.where);
  resume_timer_.arm(Clock::now() + attempt.patience);
}

void Connection::ask_to_resume() {
  const auto proof = control_->resumption_proof(welcome_.session, resumption_);
  if (!proof) return fail(*lost_);
  control_->send(protocol::Resume{welcome_.session, *proof});
  asked_to_resume_ = true;
  resume_timer_.disarm();  // the answer may take as long as that to a Hello
}

void Connection::on_resumed(protocol::Welcome welcome) {
  if (const auto wrong = objection_to(welcome, options_.hello)) return fail(*wrong);
  if (auto turned = data_->turn_to(FleetRoute::data_address(welcome, control_->server_ip())); !turned)
    return fail(turned.error());
  welcome_ = std::move(welcome);
  route_.welcomed(welcome_);
  lost_.reset();
  asked_to_resume_ = false;
  resumed_ = control_heard_ = Clock::now();
  handshake_timer_.disarm();
  if (path_.by_udp()) {
    path_ = PathWatch(options_.transport);  // its pings were not answered
    ping(*data_);                           // as at the start, for the server to validate the address anew
  }
  if (events_.resumed) events_.resumed();
}

void Connection::fail(Error error) {
  if (state_ == State::closed) return;
  close("");
  failure_ = std::move(error);
  if (events_.closed) events_.closed(*failure_);
}

}  // namespace gnomon::client
