#include "tests/unit/client/net/fake_server.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <openssl/pem.h>
#include <openssl/ssl.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstdlib>

#include "protocol/seal_exporter.h"
#include "tests/unit/client/stream/sliced.h"

namespace gnomon::tests {
namespace {

constexpr int kPatienceMs = 5000;

bool readable(int socket) {
  pollfd wait{socket, POLLIN, 0};
  return poll(&wait, 1, kPatienceMs) == 1;
}

int bound_socket(int type, uint16_t& port) {
  const int made = socket(AF_INET, type, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  if (bind(made, reinterpret_cast<sockaddr*>(&address), size) != 0) std::abort();
  getsockname(made, reinterpret_cast<sockaddr*>(&address), &size);
  port = ntohs(address.sin_port);
  return made;
}

SSL_CTX* context_with(const daemon::Identity& identity) {
  std::signal(SIGPIPE, SIG_IGN);  // OpenSSL writes to sockets that the peer has closed
  SSL_CTX* const server = SSL_CTX_new(TLS_server_method());
  const auto bio = [](const std::string& pem) { return BIO_new_mem_buf(pem.data(), static_cast<int>(pem.size())); };
  BIO* const certificate = bio(identity.certificate);
  BIO* const key = bio(identity.key);
  X509* const read_certificate = PEM_read_bio_X509(certificate, nullptr, nullptr, nullptr);
  EVP_PKEY* const read_key = PEM_read_bio_PrivateKey(key, nullptr, nullptr, nullptr);
  SSL_CTX_use_certificate(server, read_certificate);
  SSL_CTX_use_PrivateKey(server, read_key);
  X509_free(read_certificate);
  EVP_PKEY_free(read_key);
  BIO_free(certificate);
  BIO_free(key);
  return server;
}

}  // namespace

Peer::Peer(int listener, SSL_CTX* tls) {
  if (!readable(listener)) return;
  stream_ = accept(listener, nullptr, nullptr);
  const timeval patience{kPatienceMs / 1000, 0};
  setsockopt(stream_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  tls_ = SSL_new(tls);
  SSL_set_fd(tls_, stream_);
  SSL_accept(tls_);
}

Peer::~Peer() {
  hang_up();
  if (datagrams_ >= 0) close(datagrams_);
  SSL_free(tls_);
}

void Peer::hang_up() {
  if (stream_ >= 0) close(stream_);
  stream_ = -1;
}

std::string Peer::asked_name() const {
  const char* const name = tls_ ? SSL_get_servername(tls_, TLSEXT_NAMETYPE_host_name) : nullptr;
  return name ? name : "";
}

std::optional<protocol::Message> Peer::read() {
  while (true) {
    auto next = reader_.next();
    if (!next) return std::nullopt;
    if (next->has_value()) return std::move(**next);
    std::array<uint8_t, 4096> bytes;
    const int count = stream_ < 0 ? 0 : SSL_read(tls_, bytes.data(), static_cast<int>(bytes.size()));
    if (count <= 0) return std::nullopt;
    reader_.feed(std::span(bytes).first(static_cast<size_t>(count)));
  }
}

void Peer::write(const protocol::Message& message) { write_bytes(protocol::encode(message)); }

void Peer::write_bytes(std::span<const uint8_t> bytes) {
  if (stream_ >= 0) SSL_write(tls_, bytes.data(), static_cast<int>(bytes.size()));
}

void Peer::welcome(protocol::Welcome message) {
  datagrams_ = bound_socket(SOCK_DGRAM, message.data_port);
  message.session = SessionId{0x1234567890abcdef};
  const auto secrets = protocol::export_secrets(tls_, message.session, message.cipher).value();
  seal_ = std::make_unique<protocol::Seal>(message.session, message.cipher, secrets, protocol::Side::server);
  write(message);
}

std::optional<protocol::Opened> Peer::read_datagram() {
  std::array<uint8_t, 2048> bytes;
  sockaddr_storage from{};
  socklen_t size = sizeof from;
  if (!readable(datagrams_)) return std::nullopt;
  const ssize_t count =
      recvfrom(datagrams_, bytes.data(), bytes.size(), 0, reinterpret_cast<sockaddr*>(&from), &size);
  if (count <= 0) return std::nullopt;
  const auto opened = seal_->open(std::span(bytes).first(static_cast<size_t>(count)));
  if (!opened) return std::nullopt;
  const auto* address = reinterpret_cast<const uint8_t*>(&from);
  client_address_.assign(address, address + size);
  return opened;
}

std::optional<protocol::CameraUpdate> Peer::read_camera() {
  const auto opened = read_datagram();
  if (!opened) return std::nullopt;
  if (opened->header.kind == protocol::DatagramKind::ping) return read_camera();
  return protocol::decode_camera_update(opened->body);
}

bool Peer::read_ping() {
  const auto opened = read_datagram();
  return opened && opened->header.kind == protocol::DatagramKind::ping;
}

std::optional<uint64_t> Peer::read_path_response() {
  while (const auto opened = read_datagram()) {
    if (opened->header.kind == protocol::DatagramKind::path_response)
      return protocol::decode_path_token(opened->body);
  }
  return std::nullopt;
}

void Peer::challenge(uint64_t token) {
  std::vector<uint8_t> body, datagram;
  protocol::append_path_token(body, token);
  seal_->seal(protocol::DatagramKind::path_challenge, body, datagram);
  send_raw(datagram);
}

std::optional<protocol::CameraUpdate> Peer::read_camera_by_control() {
  while (const auto message = read()) {
    const auto* data = std::get_if<protocol::Data>(&*message);
    if (data && data->kind == protocol::DatagramKind::camera_update)
      return protocol::decode_camera_update(data->body);
  }
  return std::nullopt;
}

void Peer::send_frame_by_control(FrameId frame, const TileMaskView& mask) {
  const auto encoded = sliced(frame, mask, protocol::kMaxSlicePayloadBytes);
  for (size_t i = 0; i < encoded.slices.size(); ++i) {
    protocol::Data data{protocol::DatagramKind::frame_slice, i + 1, {}};
    protocol::append_frame_slice(data.body, encoded.slices[i], encoded.payload(i));
    write(data);
  }
}

std::optional<protocol::CameraUpdate> Peer::read_new_camera() {
  while (const auto camera = read_camera()) {
    if (camera->frame <= newest_) continue;
    newest_ = camera->frame;
    return camera;
  }
  return std::nullopt;
}

void Peer::send_slice(const protocol::SliceHeader& header, std::span<const uint8_t> payload) {
  std::vector<uint8_t> body, datagram;
  protocol::append_frame_slice(body, header, payload);
  seal_->seal(protocol::DatagramKind::frame_slice, body, datagram);
  send_raw(datagram);
}

void Peer::send_raw(std::span<const uint8_t> datagram) {
  sendto(datagrams_, datagram.data(), datagram.size(), 0, reinterpret_cast<const sockaddr*>(client_address_.data()),
         static_cast<socklen_t>(client_address_.size()));
}

void Peer::send_frame(FrameId frame, const TileMaskView& mask) {
  const auto encoded = sliced(frame, mask, protocol::kMaxSlicePayloadBytes);
  for (size_t i = 0; i < encoded.slices.size(); ++i) send_slice(encoded.slices[i], encoded.payload(i));
}

FakeServer::FakeServer(Script script, int connections, const daemon::Identity& identity, Turns turns)
    : tls_(context_with(identity)), address_{"127.0.0.1", 0} {
  listener_ = bound_socket(SOCK_STREAM, address_.port);
  listen(listener_, 1);
  thread_ = std::thread([this, connections, turns, script = std::move(script)] {
    std::vector<std::thread> at_once;
    for (int i = 0; i < connections; ++i) {
      auto peer = std::make_unique<Peer>(listener_, tls_);
      if (turns == Turns::at_once) {
        at_once.emplace_back([&script, peer = std::move(peer)] { script(*peer); });
      } else {
        script(*peer);
      }
    }
    for (std::thread& each : at_once) each.join();
  });
}

client::Trust FakeServer::trust(const daemon::Identity& identity) {
  return {.pin = protocol::to_string(daemon::pin_of_pem(identity.certificate).value())};
}

const daemon::Identity& FakeServer::usual_identity() {
  static const daemon::Identity made =
      daemon::make_certificate({.name = "fake", .hosts = {"localhost"}, .lasts = std::chrono::hours(1)}).value();
  return made;
}

FakeServer::~FakeServer() {
  thread_.join();
  close(listener_);
  SSL_CTX_free(tls_);
}

protocol::Welcome small_welcome(uint16_t width, uint16_t height, size_t lights) {
  protocol::Welcome welcome;
  welcome.width = width;
  welcome.height = height;
  welcome.silence_timeout_ms = 5000;
  welcome.tracer = "fake";
  welcome.scene.name = "little";
  welcome.scene.bounds_min = {-1, -1, -1};
  welcome.scene.bounds_max = {1, 1, 1};
  welcome.scene.lights.resize(lights);
  for (auto& light : welcome.scene.lights) {
    light.direction = {0, -1, 0};
    light.color = {1, 1, 1};
    light.intensity = 1;
  }
  return welcome;
}

}  // namespace gnomon::tests
