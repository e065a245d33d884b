#include "daemon/quic/http3.h"

#include <algorithm>
#include <utility>

#include "daemon/quic/qpack.h"
#include "daemon/quic/varint.h"

namespace gnomon::daemon::quic {
namespace {

// RFC 9114, 8.1 and 11.2; WebTransport's draft for the type of a bidirectional stream.
constexpr uint64_t kStreamCreationError = 0x103, kClosedCritical = 0x104, kFrameUnexpected = 0x105,
                   kExcessiveLoad = 0x107, kSettingsError = 0x109, kMissingSettings = 0x10a, kMessageError = 0x10e,
                   kQpackFailed = 0x200;
constexpr uint64_t kFrameHeaders = 1, kFrameSettings = 4, kFrameStream = 0x41;
constexpr uint64_t kTypeControl = 0, kTypePush = 1;

// What the server says of itself, in the one table that a new draft changes. Chromium 156 and Firefox 153 look for
// draft 02; Safari, and later drafts, for the ones below it.
struct Setting {
  uint64_t id, value;
};
constexpr Setting kSettings[] = {
    {0x01, 0},        // QPACK_MAX_TABLE_CAPACITY: none, so that its streams carry nothing
    {0x07, 0},        // QPACK_BLOCKED_STREAMS
    {0x08, 1},        // ENABLE_CONNECT_PROTOCOL (RFC 9220)
    {0x33, 1},        // H3_DATAGRAM (RFC 9297)
    {0x2b603742, 1},  // ENABLE_WEBTRANSPORT, draft 02
    {0xc671706a, 1},  // WEBTRANSPORT_MAX_SESSIONS, drafts 07 to 13
    {0x14e9cd29, 1},  // SETTINGS_WT_MAX_SESSIONS, draft 14
};
constexpr const char* kProtocols[] = {"webtransport", "webtransport-h3"};  // the latter from draft 15

bool is_unidirectional(int64_t stream) { return (stream & 2) != 0; }

std::string field(const Fields& fields, const char* name) {
  const auto found = fields.find(name);
  return found == fields.end() ? std::string() : found->second;
}

void append(std::vector<uint8_t>& out, uint64_t type, std::span<const uint8_t> body) {
  append_varint(out, type);
  append_varint(out, body.size());
  out.insert(out.end(), body.begin(), body.end());
}

bool are_settings(std::span<const uint8_t> body) {
  while (!body.empty()) {
    if (!take_varint(body) || !take_varint(body)) return false;
  }
  return true;
}

}  // namespace

std::vector<uint8_t> Http3::control_stream() {
  std::vector<uint8_t> settings, out;
  for (const Setting& setting : kSettings) {
    append_varint(settings, setting.id);
    append_varint(settings, setting.value);
  }
  append_varint(out, kTypeControl);
  append(out, kFrameSettings, settings);
  return out;
}

std::optional<Http3Error> Http3::receive(int64_t id, std::span<const uint8_t> bytes, bool ended) {
  if (!streams_.contains(id) && streams_.size() >= kMostStreams) return Http3Error{kExcessiveLoad};
  Stream& stream = streams_[id];
  stream.unread.insert(stream.unread.end(), bytes.begin(), bytes.end());
  if (const auto error = read(id, stream)) return error;
  if (ended && stream.kind == Stream::Kind::control) return Http3Error{kClosedCritical};
  if (ended) end(id);
  return std::nullopt;
}

void Http3::reset(int64_t stream) { end(stream); }

void Http3::end(int64_t stream) {
  streams_.erase(stream);
  ended_ = ended_ || session_ == stream;
}

std::optional<Http3Error> Http3::read(int64_t id, Stream& stream) {
  std::span<const uint8_t> bytes = stream.unread;
  std::optional<Http3Error> error = read_kind(id, stream, bytes);
  while (!error && stream.kind != Stream::Kind::unknown && !bytes.empty()) {
    if (stream.kind == Stream::Kind::ignored) {
      bytes = {};
      break;
    }
    if (stream.skip > 0) {
      const auto skipped = static_cast<size_t>(std::min<uint64_t>(stream.skip, bytes.size()));
      stream.skip -= skipped;
      bytes = bytes.subspan(skipped);
      continue;
    }
    std::span<const uint8_t> rest = bytes;
    const auto type = take_varint(rest);
    const auto length = type ? take_varint(rest) : std::nullopt;
    if (!length) break;
    const bool of_interest = *type == kFrameHeaders || *type == kFrameSettings;
    if (!of_interest) {
      if (stream.kind == Stream::Kind::control && !stream.has_settings) return Http3Error{kMissingSettings};
      stream.skip = *length;
      bytes = rest;
      continue;
    }
    if (*length > kLongestFrame) return Http3Error{kExcessiveLoad};
    if (rest.size() < *length) break;
    error = on_frame(id, stream, *type, rest.first(static_cast<size_t>(*length)));
    bytes = rest.subspan(static_cast<size_t>(*length));
  }
  stream.unread.erase(stream.unread.begin(), stream.unread.end() - static_cast<std::ptrdiff_t>(bytes.size()));
  return error;
}

// A stream of one direction begins with its type. So does one of both that belongs to a session, which we have no use
// for; others are requests.
std::optional<Http3Error> Http3::read_kind(int64_t id, Stream& stream, std::span<const uint8_t>& bytes) {
  if (stream.kind != Stream::Kind::unknown) return std::nullopt;
  std::span<const uint8_t> rest = bytes;
  const auto type = take_varint(rest);
  if (!type) return std::nullopt;
  if (!is_unidirectional(id)) {
    stream.kind = *type == kFrameStream ? Stream::Kind::ignored : Stream::Kind::request;
    return std::nullopt;
  }
  bytes = rest;
  if (*type == kTypePush) return Http3Error{kStreamCreationError};
  stream.kind = *type == kTypeControl ? Stream::Kind::control : Stream::Kind::ignored;
  if (*type == kTypeControl && std::exchange(has_control_, true)) return Http3Error{kStreamCreationError};
  return std::nullopt;
}

std::optional<Http3Error> Http3::on_frame(int64_t id, Stream& stream, uint64_t type,
                                          std::span<const uint8_t> body) {
  const bool control = stream.kind == Stream::Kind::control;
  if (type == kFrameHeaders) return control ? Http3Error{kFrameUnexpected} : on_headers(id, stream, body);
  if (!control || std::exchange(stream.has_settings, true)) return Http3Error{kFrameUnexpected};
  if (!are_settings(body)) return Http3Error{kSettingsError};
  return std::nullopt;
}

// A second session of the connection is none: its stream stays without an answer, and the first one goes on.
std::optional<Http3Error> Http3::on_headers(int64_t id, Stream& stream, std::span<const uint8_t> section) {
  if (std::exchange(stream.has_headers, true)) return std::nullopt;  // trailers
  const auto fields = decode_fields(section);
  if (!fields) return Http3Error{kQpackFailed};
  const std::string protocol = field(*fields, ":protocol");
  const bool known = std::find(std::begin(kProtocols), std::end(kProtocols), protocol) != std::end(kProtocols);
  if (field(*fields, ":method") != "CONNECT" || !known || field(*fields, ":scheme") != "https") {
    return Http3Error{kMessageError};  // nothing else is served here
  }
  if (session_) return std::nullopt;
  session_ = id;
  asked_ = SessionAsked{field(*fields, ":authority"), field(*fields, ":path"), field(*fields, "origin")};
  return std::nullopt;
}

std::optional<SessionAsked> Http3::take_asked() { return std::exchange(asked_, std::nullopt); }

std::vector<uint8_t> Http3::response(int status) const {
  std::vector<std::pair<std::string, std::string>> fields{{":status", std::to_string(status)}};
  if (status == 200) fields.emplace_back("sec-webtransport-http3-draft", "draft02");
  std::vector<uint8_t> out;
  append(out, kFrameHeaders, encode_fields(fields));
  return out;
}

std::vector<uint8_t> Http3::datagram_prefix() const {
  std::vector<uint8_t> out;
  append_varint(out, static_cast<uint64_t>(*session_) / 4);
  return out;
}

std::optional<std::span<const uint8_t>> Http3::payload(std::span<const uint8_t> datagram) const {
  const auto quarter = take_varint(datagram);
  if (!quarter || !session_ || *quarter != static_cast<uint64_t>(*session_) / 4) return std::nullopt;
  return datagram;
}

}  // namespace gnomon::daemon::quic
