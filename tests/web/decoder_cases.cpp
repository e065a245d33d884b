// Slices, and what the native client makes of them, for the decoder of browsers to repeat: tests/web/decoder_test.mjs.
//
//   decoder_cases SEEDS [MUTATIONS]      SEEDS: the corpus of fuzz_slices; MUTATIONS: of each of its files
//   decoder_cases bench                  for tests/web/decode_bench; to standard error what each stream is
//
// To standard output, little-endian: for each stream u32 width, height, lights, then its slices, each u32 size, the body,
// u32 outcome (0 none, 1 whole, 2 malformed), u32 have; of a whole frame u32 frame, scene time, lights version, server_us,
// gpu_us, payload bytes, codec, and the words. A size of 0xffffffff ends the stream. Each size is followed by 0s up to a
// multiple of four.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <set>
#include <string_view>

#include "client/stream/frame_assembler.h"
#include "common/packed_mask.h"
#include "protocol/codec.h"
#include "tests/fuzz/target.h"
#include "tests/unit/protocol/masks.h"

namespace gnomon {
namespace {

using Bytes = std::vector<uint8_t>;
std::mt19937 random_bits(23);

uint32_t below(uint32_t end) { return random_bits() % end; }

void put(uint32_t value) { std::fwrite(&value, sizeof value, 1, stdout); }

// What the native client takes of a stream of slices, written as it goes.
class Case {
 public:
  explicit Case(TileGrid grid) : assembler_(grid) {
    assembler_.keep_references();
    put(grid.width);
    put(grid.height);
    put(grid.planes);
  }
  ~Case() { put(0xffffffff); }
  Case(const Case&) = delete;
  Case& operator=(const Case&) = delete;

  // The whole frame, if this slice was the last that it lacked.
  std::optional<client::AssembledFrame> add(const Bytes& body) {
    put(static_cast<uint32_t>(body.size()));
    std::fwrite(body.data(), 1, body.size(), stdout);
    std::fwrite("\0\0\0", 1, (4 - body.size() % 4) % 4, stdout);
    const auto slice = protocol::decode_frame_slice(body);
    const auto outcome = slice ? take(*slice) : client::SliceOutcome::malformed;
    std::optional<client::AssembledFrame> whole;
    while (auto frame = assembler_.take_finished())
      if (frame->complete() && frame->frame == slice->header.frame) whole = std::move(frame);
    const bool is_whole = outcome == client::SliceOutcome::completed;
    put(outcome == client::SliceOutcome::malformed ? 2 : is_whole ? 1 : 0);
    put(assembler_.newest_reference().value);
    if (!is_whole) return std::nullopt;
    for (const uint32_t fact :
         {whole->frame.value, whole->moment.scene_time_us, whole->moment.lights_version, whole->server_us,
          whole->gpu_us, static_cast<uint32_t>(whole->payload_bytes), static_cast<uint32_t>(slice->header.codec)})
      put(fact);
    std::fwrite(whole->words.data(), sizeof whole->words[0], whole->words.size(), stdout);
    return whole;
  }

  FrameId have() const { return assembler_.newest_reference(); }

 private:
  client::SliceOutcome take(const protocol::FrameSlice& slice) {
    const TileGrid& grid = assembler_.grid();
    const bool of_other_size = (slice.header.flags & protocol::kSliceHasSize) != 0 &&
                               (slice.header.width != grid.width || slice.header.height != grid.height);
    const bool of_other_samples =
        (slice.header.flags & protocol::kSliceHasSamples) != 0 && slice.header.samples != 1;
    return of_other_size || of_other_samples ? client::SliceOutcome::late : assembler_.add(slice);
  }

  client::FrameAssembler assembler_;
};

Bytes body_of(const protocol::SliceHeader& header, std::span<const uint8_t> payload) {
  Bytes body;
  protocol::append_frame_slice(body, header, payload);
  return body;
}

void mutate(Bytes& bytes) {
  for (uint32_t i = 1 + below(4); i > 0 && !bytes.empty(); --i) {
    const size_t at = below(static_cast<uint32_t>(bytes.size()));
    switch (below(4)) {
      case 0: bytes.resize(at); break;
      case 1: bytes.insert(bytes.begin() + static_cast<ptrdiff_t>(at), static_cast<uint8_t>(below(256))); break;
      case 2: bytes[at] = static_cast<uint8_t>(below(2) ? 0xff : 0); break;
      default: bytes[at] ^= static_cast<uint8_t>(1u << below(8));
    }
  }
}

// As tests/fuzz/slices.cpp reads its input.
void add_seed(std::span<const uint8_t> input) {
  const TileGrid grid{1 + fuzz::take_number(input, 300), 1 + fuzz::take_number(input, 200),
                      1 + fuzz::take_number(input, 7)};
  protocol::SliceHeader header;
  header.frame = FrameId(1);
  header.slice_count = 1;
  header.codec = static_cast<protocol::CodecId>(fuzz::take_number(input, 3));
  header.first_tile = fuzz::take_number(input, grid.tile_count());
  header.tile_count = fuzz::take_number(input, grid.tile_count());
  header.first_light = static_cast<uint16_t>(fuzz::take_number(input, grid.planes));
  header.light_count = static_cast<uint16_t>(fuzz::take_number(input, grid.planes));
  Case(grid).add(body_of(header, input));
}

void add_corpus(const std::filesystem::path& folder, int mutations) {
  std::set<std::filesystem::path> files;
  for (const auto& file : std::filesystem::directory_iterator(folder)) files.insert(file.path());
  for (const auto& file : files) {
    std::ifstream in(file, std::ios::binary);
    const Bytes seed{std::istreambuf_iterator<char>(in), {}};
    add_seed(seed);
    for (int i = 0; i < mutations; ++i) {
      Bytes mutant = seed;
      mutate(mutant);
      add_seed(mutant);
    }
  }
}

tests::Mask random_mask(TileGrid grid, uint32_t seed) {
  switch (below(6)) {
    case 0: return tests::all_dark(grid);
    case 1: return tests::all_lit(grid);
    case 2: return tests::checkerboard(grid, 1 + below(20));
    case 3: return tests::noise(grid, seed);
    case 4: return tests::foliage(grid, seed);
    default: return tests::room(grid, seed);
  }
}

protocol::SliceHeader dressed(protocol::SliceHeader header, const TileGrid& grid, uint32_t frame) {
  header.frame = FrameId(frame);
  header.server_us = 4000 + below(1000);
  header.gpu_us = below(4000);
  if (frame % 2 == 0) {
    header.flags |= protocol::kSliceHasMoment;
    header.moment = {frame * 1000, frame};
  }
  if (frame % 3 == 0) {
    header.flags |= protocol::kSliceHasSize;
    header.width = static_cast<uint16_t>(frame % 9 == 0 && below(8) == 0 ? grid.width + 1 : grid.width);
    header.height = static_cast<uint16_t>(grid.height);
  }
  return header;
}

// Frames one after the other, of any codec; those of tiles_context refer to the newest that the client has. Slices come
// in any order, some twice, some damaged before they come whole, some never.
void add_stream(TileGrid grid, int frames) {
  Case out(grid);
  std::deque<protocol::MaskReferencePtr> shelf;
  protocol::FrameEncoder encoder;
  const uint32_t scene = random_bits();
  const auto codec_of_most = protocol::kCodecs[below(3)];
  for (uint32_t frame = 1; frame <= static_cast<uint32_t>(frames); ++frame) {
    const tests::Mask mask =
        below(3) == 0 ? random_mask(grid, random_bits()) : tests::foliage(grid, scene + frame / 3);
    tests::Mask care = tests::all_lit(grid);
    if (below(2)) care = tests::room(grid, scene + 1);
    for (size_t i = 0; i < care.words.size(); ++i) care.words[i] |= below(8) ? 0 : ~uint64_t{0};
    const PackedMask packed(mask.view(), care.words);
    const protocol::CodecId codec = below(4) == 0 ? protocol::kCodecs[below(3)] : codec_of_most;
    const protocol::MaskReference* reference = nullptr;
    for (const auto& kept : shelf)
      if (kept->frame() == out.have() && out.have().value != 0) reference = kept.get();
    protocol::EncodedMask encoded;
    if (!encoder.encode(packed.view(), codec, 600 + below(600), encoded, reference)) std::abort();
    std::vector<size_t> order(encoded.slices.size());
    for (size_t i = 0; i < order.size(); ++i) order[i] = i;
    if (below(3) == 0) std::shuffle(order.begin(), order.end(), random_bits);
    const bool loses = below(8) == 0;
    protocol::SliceHeader facts;
    for (const size_t i : order) {
      facts = dressed(encoded.slices[i], grid, frame);
      Bytes body = body_of(facts, encoded.payload(i));
      if (loses && below(4) == 0) continue;
      if (below(16) == 0) {
        Bytes damaged = body;
        mutate(damaged);
        out.add(damaged);
      }
      const auto whole = out.add(body);
      if (whole && codec == protocol::CodecId::tiles_context) {
        shelf.push_back(std::make_shared<protocol::MaskReference>(whole->frame, whole->mask()));
        if (shelf.size() > 16) shelf.pop_front();
      }
      if (below(16) == 0) out.add(body);
    }
  }
}

// A view of 1920x1080 that moves by a few pixels from frame to frame.
void add_bench_stream(uint32_t lights, protocol::CodecId codec, bool refers) {
  constexpr uint32_t kFrames = 12;
  const TileGrid grid{1920, 1080, lights};
  const tests::Mask wide = tests::foliage({grid.width + 4 * kFrames, grid.height, lights}, 5);
  Case out(grid);
  protocol::FrameEncoder encoder;
  protocol::EncodedMask encoded;
  protocol::MaskReferencePtr reference;
  std::chrono::nanoseconds native{0};
  size_t bytes = 0;
  for (uint32_t frame = 1; frame <= kFrames; ++frame) {
    const tests::Mask mask = tests::make_mask(
        grid, [&](uint32_t x, uint32_t y, uint32_t light) { return wide.view().lit(x + 4 * frame, y, light); });
    const PackedMask packed(mask.view(), tests::all_lit(grid).words);
    if (!encoder.encode(packed.view(), codec, 1132, encoded, reference.get())) std::abort();
    if (frame > 1) bytes += encoded.bytes.size();
    for (size_t i = 0; i < encoded.slices.size(); ++i) {
      encoded.slices[i].frame = FrameId(frame);
      const auto start = std::chrono::steady_clock::now();
      const auto whole = out.add(body_of(encoded.slices[i], encoded.payload(i)));
      if (frame > 1) native += std::chrono::steady_clock::now() - start;
      if (whole && refers) reference = std::make_shared<protocol::MaskReference>(whole->frame, whole->mask());
    }
  }
  std::fprintf(stderr, "%u lights, %s%s, %zu bytes a frame, native %.2f ms\n", lights, to_string(codec),
               refers ? " with references" : "", bytes / (kFrames - 1),
               std::chrono::duration<double, std::milli>(native).count() / (kFrames - 1));
}

void add_bench() {
  for (const uint32_t lights : {3u, 8u}) {
    add_bench_stream(lights, protocol::CodecId::tiles_lz4, false);
    add_bench_stream(lights, protocol::CodecId::tiles_context, false);
    add_bench_stream(lights, protocol::CodecId::tiles_context, true);
  }
}

}  // namespace
}  // namespace gnomon

int main(int argc, char** argv) {
  using namespace gnomon;
  if (argc < 2) return 2;
  if (std::string_view(argv[1]) == "bench") return add_bench(), 0;
  add_corpus(argv[1], argc > 2 ? std::atoi(argv[2]) : 0);
  for (int i = 0; i < 60; ++i) add_stream({1 + below(300), 1 + below(200), 1 + below(5)}, 12);
  add_stream({1920, 1080, 3}, 3);
  return 0;
}
