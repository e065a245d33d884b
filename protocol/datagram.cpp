#include "protocol/datagram.h"

#include <algorithm>
#include <cassert>
#include <cstring>

#include "common/sample_counts.h"
#include "protocol/fields.h"

namespace gnomon::protocol {
namespace {

template <class A>
void fields(A& a, Of<A, Header>& m) {
  a(m.kind, m.flags, m.session, m.sequence);
  a.check(std::find(kDatagramKinds.begin(), kDatagramKinds.end(), m.kind) != kDatagramKinds.end(), "unknown kind");
}

template <class A>
void fields(A& a, Of<A, SliceAck>& m) {
  a(m.frame, m.first_slice, m.slices);
}

template <class A>
void fields(A& a, Of<A, CameraUpdate>& m) {
  a(m.frame);
  fields(a, m.camera);
  a(m.client_time_us, m.display_deadline_us, m.ack_count);
  a.check(m.ack_count <= kMaxAcks, "too many acknowledgements");
  for (size_t i = 0; i < std::min<size_t>(m.ack_count, kMaxAcks); ++i) fields(a, m.acks[i]);
  if constexpr (A::kReading) {
    if (a.rest().size() >= sizeof m.have.value) a(m.have);
  } else if (m.have.value != 0) {
    a(m.have);
  }
}

template <class A>
void fields(A& a, Of<A, SliceHeader>& m) {
  a(m.frame, m.slice, m.slice_count, m.first_tile, m.tile_count, m.first_light, m.light_count);
  a(m.codec, m.flags, m.padding, m.server_us, m.gpu_us);
  if (m.flags & kSliceHasMoment) a(m.moment.scene_time_us, m.moment.lights_version);
  if (m.flags & kSliceHasSize) a(m.width, m.height);
  if (m.flags & kSliceHasSamples) {
    a(m.samples);
    a.check(is_valid(sample_counts_of(m.samples)), "samples other than 1, 4 or 16, or of unknown occlusion");
  }
  a.check(m.slice < m.slice_count, "slice is not below slice_count");
  a.check(m.tile_count > 0 && m.light_count > 0, "an empty slice");
}

}  // namespace

std::optional<Header> decode_header(std::span<const uint8_t> datagram) {
  Reader reader(datagram);
  uint8_t version = 0;
  Header header;
  reader(version);
  reader.check(version == kVersion, "unknown version");
  fields(reader, header);
  if (!reader.ok()) return std::nullopt;
  return header;
}

std::optional<CameraUpdate> decode_camera_update(std::span<const uint8_t> body) {
  Reader reader(body);
  CameraUpdate update;
  fields(reader, update);
  if (!reader.ok()) return std::nullopt;
  return update;
}

std::optional<FrameSlice> decode_frame_slice(std::span<const uint8_t> body) {
  Reader reader(body);
  FrameSlice slice;
  fields(reader, slice.header);
  if (!reader.ok()) return std::nullopt;
  slice.payload = reader.rest();
  if (slice.header.flags & kSliceIsPadded) {
    if (slice.header.padding > slice.payload.size()) return std::nullopt;
    slice.payload = slice.payload.first(slice.payload.size() - slice.header.padding);
  }
  return slice;
}

std::optional<uint64_t> decode_path_token(std::span<const uint8_t> body) {
  Reader reader(body);
  uint64_t token = 0;
  reader(token);
  if (!reader.ok()) return std::nullopt;
  return token;
}

void write_header(std::span<uint8_t, kHeaderBytes> out, const Header& header) {
  out[0] = static_cast<uint8_t>(kVersion);
  out[1] = static_cast<uint8_t>(header.kind);
  std::memcpy(&out[2], &header.flags, 2);
  std::memcpy(&out[4], &header.session.value, 8);
  std::memcpy(&out[12], &header.sequence, 8);
}

void append_camera_update(std::vector<uint8_t>& out, const CameraUpdate& update) {
  assert(update.ack_count <= kMaxAcks);
  Writer writer(out);
  fields(writer, update);
}

void append_path_token(std::vector<uint8_t>& out, uint64_t token) {
  Writer writer(out);
  writer(token);
}

void append_frame_slice(std::vector<uint8_t>& out, const SliceHeader& header, std::span<const uint8_t> payload) {
  Writer writer(out);
  fields(writer, header);
  out.insert(out.end(), payload.begin(), payload.end());
}

}  // namespace gnomon::protocol
