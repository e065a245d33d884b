// A minimal client: blocking, one frame at a time, with a limit on every wait.
#pragma once

#include <asio/connect.hpp>
#include <asio/io_context.hpp>
#include <asio/ip/tcp.hpp>
#include <asio/ip/udp.hpp>
#include <asio/ssl.hpp>
#include <asio/write.hpp>
#include <functional>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "common/light_planes.h"
#include "protocol/codec.h"
#include "protocol/feedback.h"
#include "protocol/messages.h"
#include "protocol/pin.h"
#include "protocol/seal_exporter.h"

namespace gnomon::daemon {

// Far longer than anything here takes: a test that reaches this limit has failed.
inline constexpr std::chrono::seconds kPatience{20};

class TestClient {
 public:
  // Accepts any certificate. `prepare` may change the TLS options before the handshake, `greeting` goes before it.
  explicit TestClient(uint16_t control_port, const std::function<void(SSL*)>& prepare = {},
                      const std::vector<uint8_t>& greeting = {})
      : control_(io_, tls_), data_(io_) {
    SSL_set_alpn_protos(control_.native_handle(), protocol::kAlpn.data(), protocol::kAlpn.size());
    if (prepare) prepare(control_.native_handle());
    control_.next_layer().connect({asio::ip::address_v4::loopback(), control_port});
    asio::write(control_.next_layer(), asio::buffer(greeting));
    asio::error_code refused;
    control_.handshake(asio::ssl::stream_base::client, refused);
    shook_hands_ = !refused;
    data_.open(asio::ip::udp::v4());
    data_.bind({asio::ip::address_v4::loopback(), 0});
  }

  static protocol::Hello hello(const std::string& scene, uint16_t width = 32, uint16_t height = 24) {
    protocol::Hello hello;
    hello.client = "test";
    hello.features = protocol::kFeaturePaths;
    hello.scene = scene;
    hello.width = width;
    hello.height = height;
    return hello;
  }

  bool shook_hands() const { return shook_hands_; }
  protocol::Pin server_pin() { return protocol::pin_of(SSL_get0_peer_certificate(control_.native_handle())); }

  // Returns false if the server has closed the connection.
  bool send_bytes(const std::vector<uint8_t>& bytes) {
    asio::error_code error;
    asio::write(control_, asio::buffer(bytes), error);
    return !error;
  }
  bool send(const protocol::Message& message) { return send_bytes(protocol::encode(message)); }

  // Returns the next message; nullopt if the server has closed the connection or the wait is too long.
  std::optional<protocol::Message> receive() {
    while (true) {
      auto message = reader_.next();
      if (!message) return std::nullopt;
      if (message->has_value()) return std::move(**message);
      size_t got = 0;
      asio::error_code failed = asio::error::timed_out;
      control_.async_read_some(asio::buffer(incoming_), [&](asio::error_code error, size_t bytes) {
        failed = error;
        got = bytes;
      });
      wait(control_.next_layer());
      if (failed) return std::nullopt;
      reader_.feed(std::span(incoming_).first(got));
    }
  }

  // Returns the next message of type M and skips others.
  template <class M>
  std::optional<M> receive_a() {
    while (auto message = receive()) {
      if (const M* wanted = std::get_if<M>(&*message)) return *wanted;
    }
    return std::nullopt;
  }

  // Sends a Hello and receives the Welcome. Unless `proves` is false, the client has the feature paths and proves its
  // address at once.
  bool join(protocol::Hello hello, bool proves = true) {
    if (proves) hello.features |= protocol::kFeaturePaths;
    send(hello);
    const auto welcome = receive_a<protocol::Welcome>();
    if (!welcome) return false;
    welcome_ = *welcome;
    const auto secrets = protocol::export_secrets(control_.native_handle(), welcome_.session, welcome_.cipher);
    if (!secrets) return false;
    resumption_ = protocol::export_resumption_secret(control_.native_handle(), welcome_.session).value();
    seal_ = std::make_unique<protocol::Seal>(welcome_.session, welcome_.cipher, *secrets, protocol::Side::client);
    return !proves || (send_ping() && validate_address());
  }
  const protocol::Welcome& welcome() const { return welcome_; }
  // Of the granted samples.
  LightPlanes planes() const {
    std::vector<bool> is_area(welcome_.scene.lights.size());
    for (size_t i = 0; i < welcome_.areas.size(); ++i) is_area[i] = welcome_.areas[i].is_area();
    return LightPlanes(is_area, sample_counts_of(welcome_.samples));
  }

  // Resumes the session of a client whose control connection may be lost, over this client's connection. Returns false
  // if it is refused or not answered.
  bool resume(TestClient& other, bool proves = true) {
    send(protocol::Resume{other.welcome_.session, proof_of(other)});
    const auto answer = receive();
    const auto* welcome = answer ? std::get_if<protocol::Welcome>(&*answer) : nullptr;
    if (const auto* refused = answer ? std::get_if<protocol::Refused>(&*answer) : nullptr) refused_ = *refused;
    if (!welcome) return false;
    welcome_ = *welcome;
    resumption_ = other.resumption_;
    seal_ = std::move(other.seal_);
    return !proves || (send_ping() && validate_address());
  }
  protocol::Bytes32 proof_of(TestClient& other) {
    return protocol::resumption_proof(control_.native_handle(), other.welcome_.session, other.resumption_).value();
  }
  const protocol::Refused& refused() const { return refused_; }
  void lose_control() { control_.next_layer().close(); }

  std::vector<uint8_t> sealed_view(uint32_t frame, float x) {
    protocol::CameraUpdate update;
    update.frame = FrameId{frame};
    update.camera.position[0] = x;
    update.have = have_;
    std::vector<uint8_t> body, datagram;
    protocol::append_camera_update(body, update);
    seal_->seal(protocol::DatagramKind::camera_update, body, datagram);
    return datagram;
  }
  void send_datagram(const std::vector<uint8_t>& datagram) {
    data_.send_to(asio::buffer(datagram), {asio::ip::address_v4::loopback(), welcome_.data_port});
  }
  void send_view(uint32_t frame, float x) { send_datagram(sealed_view(frame, x)); }

  void send_feedback(const protocol::Feedback& feedback) {
    std::vector<uint8_t> body, datagram;
    protocol::append_feedback(body, feedback);
    seal_->seal(protocol::DatagramKind::feedback, body, datagram);
    send_datagram(datagram);
  }

  // As send_view(), over the control connection.
  void send_view_by_control(uint32_t frame, float x) {
    protocol::Data data;
    protocol::CameraUpdate update;
    update.frame = FrameId{frame};
    update.camera.position[0] = x;
    protocol::append_camera_update(data.body, update);
    send(data);
  }

  std::vector<uint64_t> receive_frame_by_control(uint32_t frame) {
    const TileGrid grid{welcome_.width, welcome_.height, planes().total()};
    std::vector<uint64_t> words(grid.word_count());
    for (size_t slices = 0, wanted = 1; slices < wanted;) {
      const auto data = receive_a<protocol::Data>();
      if (!data) return {};
      const auto slice = protocol::decode_frame_slice(data->body);
      if (!slice || !protocol::decode_slice(slice->header, slice->payload, grid, words)) return {};
      if (slice->header.frame != FrameId{frame}) continue;
      wanted = slice->header.slice_count;
      ++slices;
    }
    return words;
  }

  std::vector<uint8_t> sealed(protocol::DatagramKind kind, std::span<const uint8_t> body) {
    std::vector<uint8_t> datagram;
    seal_->seal(kind, body, datagram);
    return datagram;
  }
  bool send_ping() {
    send_datagram(sealed(protocol::DatagramKind::ping, std::vector<uint8_t>(protocol::kPingBytes)));
    return true;
  }
  // nullopt if none arrived.
  std::optional<protocol::Header> ping() {
    send_ping();
    const auto answer = receive_datagram();
    const auto opened = answer ? seal_->open(*answer) : std::nullopt;
    return opened && answer->size() == protocol::kMaxDatagramBytes ? std::optional(opened->header) : std::nullopt;
  }

  // The next datagram, opened; nullopt if none arrived or it is not authentic. The body is valid until the next call.
  std::optional<protocol::Opened> receive_opened(std::chrono::milliseconds patience = kPatience) {
    const auto datagram = receive_datagram(patience);
    return datagram ? seal_->open(*datagram) : std::nullopt;
  }
  // Answers the next challenge. Drops what comes before it. False if none comes.
  bool validate_address() {
    while (const auto opened = receive_opened()) {
      if (opened->header.kind != protocol::DatagramKind::path_challenge) continue;
      const std::vector<uint8_t> token(opened->body.begin(), opened->body.end());
      send_datagram(sealed(protocol::DatagramKind::path_response, token));
      return true;
    }
    return false;
  }

  // All tiles of `frame`, assembled from its slices; empty if it did not arrive or could not be decoded.
  std::vector<uint64_t> receive_frame(uint32_t frame) {
    const TileGrid grid{welcome_.width, welcome_.height, planes().total()};
    std::vector<uint64_t> words(grid.word_count());
    for (size_t slices = 0, wanted = 1; slices < wanted;) {
      const auto opened = receive_opened();
      if (!opened) return {};
      if (opened->header.kind == protocol::DatagramKind::path_challenge) continue;
      const auto slice = protocol::decode_frame_slice(opened->body);
      if (!slice) return {};
      if (slice->header.frame != FrameId{frame}) continue;
      if (!protocol::decode_slice(slice->header, slice->payload, grid, words, &references_)) return {};
      codec_ = slice->header.codec;
      referred_ = codec_ == protocol::CodecId::tiles_context && slice->payload[0] != 0;
      wanted = slice->header.slice_count;
      ++slices;
    }
    if (codec_ == protocol::CodecId::tiles_context && welcome_.features & protocol::kFeatureReferences) {
      have_ = FrameId{frame};
      references_.add(std::make_shared<protocol::MaskReference>(have_, TileMaskView{grid, words}));
    }
    return words;
  }
  // The codec of the last frame, and whether it referred to an earlier frame.
  protocol::CodecId codec() const { return codec_; }
  bool referred() const { return referred_; }
  void forget_references() { references_.clear(); }

  std::optional<std::vector<uint8_t>> receive_datagram(std::chrono::milliseconds patience = kPatience) {
    std::vector<uint8_t> datagram(2048);
    asio::error_code failed = asio::error::timed_out;
    data_.async_receive(asio::buffer(datagram), [&](asio::error_code error, size_t bytes) {
      failed = error;
      datagram.resize(error ? 0 : bytes);
    });
    wait(data_, patience);
    if (failed) return std::nullopt;
    return datagram;
  }

  // The client's address changes, as when it moves to another network.
  void change_data_port() {
    data_.close();
    data_.open(asio::ip::udp::v4());
    data_.bind({asio::ip::address_v4::loopback(), 0});
  }

  void vanish() {
    control_.next_layer().close();
    data_.close();
  }

 private:
  template <class Socket>
  void wait(Socket& socket, std::chrono::milliseconds patience = kPatience) {
    io_.restart();
    io_.run_for(patience);
    if (io_.stopped()) return;
    socket.cancel();
    io_.run();
  }

  bool shook_hands_ = false;
  asio::io_context io_;
  asio::ssl::context tls_{asio::ssl::context::tls_client};
  asio::ssl::stream<asio::ip::tcp::socket> control_;
  asio::ip::udp::socket data_;
  std::array<uint8_t, 4096> incoming_;
  protocol::MessageReader reader_;
  protocol::Welcome welcome_;
  protocol::Refused refused_;
  protocol::ReferenceShelf references_;
  FrameId have_;
  protocol::CodecId codec_{};
  bool referred_ = false;
  protocol::Secret resumption_{};
  std::unique_ptr<protocol::Seal> seal_;
};

}  // namespace gnomon::daemon
