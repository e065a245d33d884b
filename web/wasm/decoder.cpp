// The decoder of browsers: the native client's own assembler of frames behind functions of numbers. decoder.js wraps it,
// and is the only one to call these. One thread.
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "client/stream/frame_assembler.h"
#include "common/light_planes.h"
#include "protocol/codec.h"
#include "protocol/datagram.h"

#define GNOMON_EXPORT(name) extern "C" __attribute__((export_name(#name)))

namespace {

using namespace gnomon;

// What decoder.js reads of a frame, as numbers of 32 bits one behind the other.
struct Taken {
  uint32_t frame;
  const uint64_t* words;
  uint32_t word_count;
  uint32_t scene_time_us;
  uint32_t lights_version;
  uint32_t server_us;
  uint32_t gpu_us;
  uint32_t payload_bytes;
  uint32_t codec;
};

enum Answer : int32_t { kNothingYet = 0, kWhole = 1, kMalformed = 2 };

// A body on the control connection has at most 16,000 bytes (WIRE.md, Data).
constexpr uint32_t kMostBytes = 1 << 16;
// Of a frame's mask, which is there up to 24 times: those being put together, those kept for references, spare memory.
constexpr uint64_t kMostWords = uint64_t{1} << 23;

uint8_t body[kMostBytes];

struct Stream {
  // Of slices that say nothing of it.
  struct Granted {
    uint32_t width, height, samples;
  };

  Stream(TileGrid grid, uint32_t samples_in_force, Granted as_granted)
      : assembler(grid), samples(samples_in_force), granted(as_granted) {
    assembler.keep_references();
  }

  client::FrameAssembler assembler;
  uint32_t samples;  // as the wire says them
  Granted granted;
  std::optional<client::AssembledFrame> frame;
  Taken taken{};
  std::vector<uint64_t> decoded;  // of the next slice, by another worker

  bool is_of_this_shape(const protocol::SliceHeader& header) const {
    const bool says_size = header.flags & protocol::kSliceHasSize;
    const bool says_samples = header.flags & protocol::kSliceHasSamples;
    return (says_size ? header.width : granted.width) == assembler.grid().width &&
           (says_size ? header.height : granted.height) == assembler.grid().height &&
           (says_samples ? header.samples : granted.samples) == samples;
  }

  // Whether it is worth to have another worker decode it.
  bool is_long_work(std::span<const uint8_t> bytes) const {
    const auto slice = protocol::decode_frame_slice(bytes);
    return slice && slice->header.codec == protocol::CodecId::tiles_context && is_of_this_shape(slice->header) &&
           assembler.fits(slice->header);
  }

  // `decoded`: its words, where another worker has decoded it.
  Answer add(std::span<const uint8_t> bytes, std::optional<std::span<const uint64_t>> decoded) {
    const auto slice = protocol::decode_frame_slice(bytes);
    if (!slice) return kMalformed;
    if (!is_of_this_shape(slice->header)) return kNothingYet;
    const auto outcome = decoded ? assembler.add_decoded(*slice, *decoded) : assembler.add(*slice);
    if (frame) assembler.recycle(*std::exchange(frame, std::nullopt));
    while (auto finished = assembler.take_finished()) {
      if (finished->complete() && finished->frame == slice->header.frame) {
        frame = std::move(finished);
      } else {
        assembler.recycle(std::move(*finished));  // given up: tiles are missing
      }
    }
    if (outcome == client::SliceOutcome::malformed) return kMalformed;
    if (outcome != client::SliceOutcome::completed || !frame) return kNothingYet;
    taken = {frame->frame.value,
             frame->words.data(),
             static_cast<uint32_t>(frame->words.size()),
             frame->moment.scene_time_us,
             frame->moment.lights_version,
             frame->server_us,
             frame->gpu_us,
             static_cast<uint32_t>(frame->payload_bytes),
             static_cast<uint32_t>(slice->header.codec)};
    return kWhole;
  }
};

// Decodes slices for a stream in another worker, which has the same references.
struct Lane {
  explicit Lane(TileGrid of_grid) : grid(of_grid), mask(of_grid.word_count()) {}

  TileGrid grid;
  std::vector<uint64_t> mask;  // where slices are decoded, and a reference's words are put
  std::vector<uint64_t> words;
  protocol::ReferenceShelf references;

  // How many words it has; 0: it does not decode here.
  uint32_t decode(std::span<const uint8_t> bytes) {
    const auto slice = protocol::decode_frame_slice(bytes);
    if (!slice) return 0;
    const auto& header = slice->header;
    if (!protocol::decode_slice(header, slice->payload, grid, mask, &references)) return 0;
    words.clear();
    for (uint32_t light = header.first_light; light < uint32_t{header.first_light} + header.light_count; ++light) {
      const auto first = mask.begin() + static_cast<std::ptrdiff_t>(light * grid.tile_count() + header.first_tile);
      words.insert(words.end(), first, first + header.tile_count);
    }
    return static_cast<uint32_t>(words.size());
  }
};

bool is_mask(uint32_t width, uint32_t height, uint32_t planes) {
  constexpr uint32_t kMostPlanes = protocol::kMaxLights * planes_of(kMostSamples) + planes_of(Occlusion::full);
  const auto is_side = [](uint32_t side) { return side > 0 && side <= protocol::kMaxSide; };
  return is_side(width) && is_side(height) && planes > 0 && planes <= kMostPlanes &&
         TileGrid{width, height, planes}.word_count() <= kMostWords;
}

}  // namespace

// Where the next body is put.
GNOMON_EXPORT(body) uint8_t* body_place() { return body; }
GNOMON_EXPORT(most_bytes) uint32_t most_bytes() { return kMostBytes; }

// nullptr if a mask of that size and number of planes is none, or needs more memory than there may be. `samples`: of area
// lights, in force.
GNOMON_EXPORT(open)
Stream* open_stream(uint32_t width, uint32_t height, uint32_t planes, uint32_t samples, uint32_t granted_width,
                    uint32_t granted_height, uint32_t granted_samples) {
  if (!is_mask(width, height, planes)) return nullptr;
  return new Stream({width, height, planes}, samples, {granted_width, granted_height, granted_samples});
}

GNOMON_EXPORT(close) void close_stream(Stream* stream) { delete stream; }

// Takes the body that was put in its place. What is whole then is borrowed until the next call.
GNOMON_EXPORT(slice) int32_t slice(Stream* stream, uint32_t bytes) {
  return bytes > kMostBytes ? kMalformed : stream->add(std::span<const uint8_t>(body, bytes), std::nullopt);
}
GNOMON_EXPORT(taken) const Taken* taken(const Stream* stream) { return &stream->taken; }
GNOMON_EXPORT(have) uint32_t have(const Stream* stream) { return stream->assembler.newest_reference().value; }

// ---- slices that other workers decode

GNOMON_EXPORT(is_long_work) int32_t is_long_work(const Stream* stream, uint32_t bytes) {
  return bytes <= kMostBytes && stream->is_long_work(std::span<const uint8_t>(body, bytes));
}
// Where so many words of a slice are put that was decoded elsewhere, for decoded_slice().
GNOMON_EXPORT(decoded_place) uint64_t* decoded_place(Stream* stream, uint32_t words) {
  stream->decoded.resize(words);
  return stream->decoded.data();
}
GNOMON_EXPORT(decoded_slice) int32_t decoded_slice(Stream* stream, uint32_t bytes) {
  return bytes > kMostBytes ? kMalformed : stream->add(std::span<const uint8_t>(body, bytes), stream->decoded);
}

GNOMON_EXPORT(open_lane) Lane* open_lane(uint32_t width, uint32_t height, uint32_t planes) {
  return is_mask(width, height, planes) ? new Lane({width, height, planes}) : nullptr;
}
GNOMON_EXPORT(close_lane) void close_lane(Lane* lane) { delete lane; }
GNOMON_EXPORT(lane_slice) uint32_t lane_slice(Lane* lane, uint32_t bytes) {
  return bytes > kMostBytes ? 0 : lane->decode(std::span<const uint8_t>(body, bytes));
}
GNOMON_EXPORT(lane_words) const uint64_t* lane_words(const Lane* lane) { return lane->words.data(); }
// Where the words of a frame are put that slices may refer to, for lane_keep().
GNOMON_EXPORT(lane_mask) uint64_t* lane_mask(Lane* lane) { return lane->mask.data(); }
GNOMON_EXPORT(lane_keep) void lane_keep(Lane* lane, uint32_t frame) {
  lane->references.add(
      std::make_shared<protocol::MaskReference>(FrameId(frame), TileMaskView{lane->grid, lane->mask}));
}
