#include "protocol/context/context_slices.h"

#include <algorithm>
#include <utility>

#include "protocol/context/motion_search.h"
#include "protocol/context/tile_walk.h"

namespace gnomon::protocol::context {
namespace {

// A payload's first byte.
enum class Form : uint8_t { alone = 0, referenced = 1 };
constexpr size_t kReferencedHead = 1 + sizeof(uint32_t) + sizeof(uint32_t);

constexpr size_t kMixedBits = 12;      // expected of a mixed tile
constexpr size_t kSlicesOfAUnit = 12;  // expected of a unit, at least, where several share a light

void append_u32(std::vector<uint8_t>& bytes, uint32_t value) {
  for (int shift = 0; shift < 32; shift += 8) bytes.push_back(static_cast<uint8_t>(value >> shift));
}
uint32_t read_u32(const uint8_t* bytes) {
  uint32_t value;
  std::memcpy(&value, bytes, sizeof value);
  return value;
}

// Model and working memory to encode or decode one slice at a time.
template <bool Referenced>
struct Kit {
  SliceModel<Referenced> model;
  WalkMemory walk;

  void fit(const TileGrid& grid) {
    if (grid.tiles_x() * 8 != static_cast<uint32_t>(walk.rows.width()) ||
        grid.tiles_y() * 8 != static_cast<uint32_t>(walk.rows.height()))
      walk.rows.reset(grid.tiles_x(), grid.tiles_y());
    model.reset();
  }
};

size_t count_mixed(std::span<const PackedClass> classes) {
  return static_cast<size_t>(std::count(classes.begin(), classes.end(), PackedClass::mixed));
}

}  // namespace

void FrameTiles::take(const PackedMaskView& mask) {
  grid = mask.grid;
  classes.resize(grid.word_count());
  words.resize(grid.word_count());
  size_t next = 0;
  for (size_t i = 0; i < classes.size(); ++i) {
    classes[i] = mask.class_of(i);
    if (classes[i] == PackedClass::mixed) words[i] = mask.mixed[next++];
  }
}

void FrameTiles::take(const TileMaskView& mask) {
  grid = mask.grid;
  classes.resize(grid.word_count());
  words.assign(mask.words.begin(), mask.words.end());
  for (size_t i = 0; i < classes.size(); ++i)
    classes[i] = words[i] == 0 ? PackedClass::dark : ~words[i] == 0 ? PackedClass::lit : PackedClass::mixed;
}

void FrameTiles::refer_to(const MaskReference* frame, const std::optional<CameraView>& now) {
  reference = frame;
  camera.reset();
  if (frame && now && frame->camera()) camera.emplace(*now, *frame->camera(), frame->grid());
}

struct UnitEncoder::Memory {
  Kit<false> alone;
  Kit<true> referenced;
  std::vector<Motion> motions;       // of one light
  std::vector<uint64_t> words_kept;  // what the first of two attempts makes of a slice's tiles
  std::vector<uint8_t> bytes_kept;   // and its payload

  FrameTiles* frame = nullptr;
  size_t limit = 0;
  EncodedMask* out = nullptr;

  std::span<uint64_t> words_of(uint32_t light, uint32_t first_tile, uint32_t tiles) const {
    return std::span(frame->words).subspan(size_t{light} * frame->grid.tile_count() + first_tile, tiles);
  }

  template <bool Referenced>
  LightTiles light(uint32_t number) {
    const TileGrid& grid = frame->grid;
    const size_t first = size_t{number} * grid.tile_count();
    return {std::span(frame->classes).subspan(first, grid.tile_count()), words_of(number, 0, grid.tile_count()),
            Referenced ? &frame->reference->rows(number) : nullptr, motions};
  }

  void find_motions_of(const SliceRange& range, uint32_t number) {
    const TileGrid& grid = frame->grid;
    const uint32_t rows_of_block = grid.tiles_x() * kBlock;
    motions.resize(size_t{(grid.tiles_x() + kBlock - 1) / kBlock} * ((grid.tiles_y() + kBlock - 1) / kBlock));
    const BlockRows rows{range.first_tile / rows_of_block,
                         (range.first_tile + range.tile_count + rows_of_block - 1) / rows_of_block};
    find_motions(grid, light<true>(number), frame->camera ? &*frame->camera : nullptr, rows, motions);
  }

  void encode(const SliceRange& unit) {
    if (unit.light_count > 1 && encode_lights(unit)) return;
    Choice choice = frame->reference ? Choice::open : Choice::alone;
    for (uint32_t l = 0; l < unit.light_count; ++l) {
      SliceRange range{unit.first_tile, unit.tile_count, unit.first_light + l, 1};
      if (choice != Choice::alone) find_motions_of(range, range.first_light);
      const uint32_t end = unit.first_tile + unit.tile_count;
      while (range.first_tile < end) {
        range.tile_count = end - range.first_tile;
        range.tile_count = encode_slice(range, choice);
        append(range);
        range.first_tile += range.tile_count;
      }
    }
  }

  // How the further slices of a unit are encoded.
  enum class Choice : uint8_t { open, referenced, alone };

  // With a reference where that takes fewer bytes. Both ways are tried until one is clearly ahead, and the rest of the
  // unit follows it: neighbours differ little in what a reference brings. Returns the number of tiles.
  uint32_t encode_slice(const SliceRange& range, Choice& choice) {
    if (choice == Choice::referenced) return encode_some(range, referenced);
    if (choice == Choice::alone) return encode_some(range, alone);
    const size_t begin = out->bytes.size();
    SliceRange same = range;
    same.tile_count = encode_some(range, referenced);
    const size_t with = out->bytes.size() - begin;
    keep(begin, words_of(range.first_light, range.first_tile, same.tile_count));
    const uint32_t fit = within(with + with / 10 + kReferencedHead, [&] { return encode_some(same, alone); });
    const size_t without = out->bytes.size() - begin;
    if (fit < same.tile_count || without >= with) {
      if (clearly_fewer(fit, same.tile_count)) choice = Choice::referenced;
      bring_back(begin, words_of(range.first_light, range.first_tile, same.tile_count));
      return same.tile_count;
    }
    if (clearly_more(with, without)) choice = Choice::alone;
    out->bytes.resize(begin);
    return encode_some(range, alone);  // more tiles may fit
  }

  // Has `attempt` give up where it takes clearly more than `bytes`.
  template <class Attempt>
  auto within(size_t bytes, Attempt attempt) -> decltype(attempt()) {
    const size_t all = std::exchange(limit, std::min(limit, bytes + BinaryEncoder::kTail));
    const auto result = attempt();
    limit = all;
    return result;
  }

  // By a tenth, and more than the segment that may just have missed the limit of a payload.
  static bool clearly_fewer(uint32_t tiles, uint32_t than) { return tiles + tiles / 10 + kSegment < than; }
  // By a tenth, and more than what a payload's head may account for.
  static bool clearly_more(size_t bytes, size_t than) { return bytes > than + than / 10 + kReferencedHead; }

  void keep(size_t begin, std::span<const uint64_t> words) {
    bytes_kept.assign(out->bytes.begin() + static_cast<ptrdiff_t>(begin), out->bytes.end());
    words_kept.assign(words.begin(), words.end());
    out->bytes.resize(begin);
  }
  void bring_back(size_t begin, std::span<uint64_t> words) const {
    out->bytes.resize(begin);
    out->bytes.insert(out->bytes.end(), bytes_kept.begin(), bytes_kept.end());
    std::copy(words_kept.begin(), words_kept.end(), words.begin());
  }

  template <bool Referenced>
  void begin_payload() {
    out->bytes.push_back(static_cast<uint8_t>(Referenced ? Form::referenced : Form::alone));
    if constexpr (Referenced) {
      append_u32(out->bytes, frame->reference->frame().value);
      append_u32(out->bytes, frame->reference->checksum());
    }
  }

  // Encodes as many tiles of one light as fit, from the range's first on, and returns their number. That is 0 only within
  // a limit below kMinPayloadBytes.
  template <bool Referenced>
  uint32_t encode_some(const SliceRange& range, Kit<Referenced>& kit) {
    const size_t begin = out->bytes.size();
    const uint32_t end = range.first_tile + range.tile_count;
    // `most`: tiles of the first segment, which may not fit a payload.
    for (uint32_t most = kSegment; most > 0; most /= 2) {
      begin_payload<Referenced>();
      kit.fit(frame->grid);
      BinaryEncoder coder(out->bytes);
      TileWalk walk(coder, kit.model, frame->grid, kit.walk);
      walk.begin(light<Referenced>(range.first_light), range.first_tile);
      uint32_t next = range.first_tile;
      while (next < end) {
        uint32_t segment = std::min(end, segment_end(next, frame->grid.tiles_x()));
        if (next == range.first_tile) segment = std::min(segment, next + most);
        const BinaryEncoder::Mark before = coder.mark();
        walk.segment(next, segment);
        if (coder.size() - begin > limit) {
          coder.return_to(before);
          break;
        }
        next = segment;
        if (next % frame->grid.tiles_x() % kSegment != 0 && next % frame->grid.tiles_x() != 0) break;
      }
      if (next > range.first_tile) {
        coder.finish();
        return next - range.first_tile;
      }
      out->bytes.resize(begin);
    }
    return 0;
  }

  // Encodes all tiles of several lights as one slice. False if they do not fit; nothing is then appended.
  bool encode_lights(const SliceRange& range) {
    const size_t begin = out->bytes.size();
    const uint32_t tiles = frame->grid.tile_count();  // of each light: a unit of several lights has all
    const std::span<uint64_t> words = words_of(range.first_light, 0, range.light_count * tiles);
    const bool with = frame->reference && try_lights(range, referenced);
    const size_t bytes_with = out->bytes.size() - begin;
    if (with) keep(begin, words);
    const bool without =
        with ? within(bytes_with, [&] { return try_lights(range, alone); }) : try_lights(range, alone);
    if (with && (!without || bytes_with <= out->bytes.size() - begin)) bring_back(begin, words);
    if (with || without) append(range);
    return with || without;
  }

  template <bool Referenced>
  bool try_lights(const SliceRange& range, Kit<Referenced>& kit) {
    const size_t begin = out->bytes.size();
    begin_payload<Referenced>();
    kit.fit(frame->grid);
    BinaryEncoder coder(out->bytes);
    TileWalk walk(coder, kit.model, frame->grid, kit.walk);
    const uint32_t end = range.first_tile + range.tile_count;
    for (uint32_t l = 0; l < range.light_count; ++l) {
      if constexpr (Referenced) find_motions_of(range, range.first_light + l);
      walk.begin(light<Referenced>(range.first_light + l), range.first_tile);
      for (uint32_t next = range.first_tile; next < end;) {
        const uint32_t segment = std::min(end, segment_end(next, frame->grid.tiles_x()));
        walk.segment(next, segment);
        next = segment;
        if (coder.size() - begin <= limit) continue;
        out->bytes.resize(begin);
        return false;
      }
    }
    coder.finish();
    return true;
  }

  void append(const SliceRange& range) const {
    SliceHeader header;
    header.first_tile = range.first_tile;
    header.tile_count = range.tile_count;
    header.first_light = static_cast<uint16_t>(range.first_light);
    header.light_count = static_cast<uint16_t>(range.light_count);
    header.codec = CodecId::tiles_context;
    out->slices.push_back(header);
    out->offsets.push_back(out->bytes.size());
  }
};

UnitEncoder::UnitEncoder() : memory_(std::make_unique<Memory>()) {}
UnitEncoder::~UnitEncoder() = default;

void UnitEncoder::encode(FrameTiles& frame, const SliceRange& unit, size_t max_payload_bytes, EncodedMask& out) {
  memory_->frame = &frame;
  memory_->limit = max_payload_bytes;
  memory_->out = &out;
  memory_->encode(unit);
}

std::vector<SliceRange> plan_units(const FrameTiles& frame, size_t max_payload_bytes) {
  std::vector<SliceRange> units;
  const uint32_t tiles = frame.grid.tile_count();
  size_t shared_bytes = 0;  // of the last unit, if further lights may join it; else 0
  for (uint32_t light = 0; light < frame.grid.planes; ++light) {
    const auto classes = std::span(frame.classes).subspan(size_t{light} * tiles, tiles);
    const size_t bytes = (count_mixed(classes) * kMixedBits + tiles / 16) / 8;
    if (bytes <= max_payload_bytes / 2) {
      if (!units.empty() && shared_bytes > 0 && shared_bytes + bytes <= max_payload_bytes / 2) {
        ++units.back().light_count;
        shared_bytes += bytes;
      } else {
        units.push_back({0, tiles, light, 1});
        shared_bytes = bytes + 1;
      }
      continue;
    }
    shared_bytes = 0;
    const size_t bands = std::clamp<size_t>(bytes / max_payload_bytes / kSlicesOfAUnit, 1, frame.grid.tiles_y());
    for (size_t band = 0; band < bands; ++band) {
      const auto first = static_cast<uint32_t>(frame.grid.tiles_y() * band / bands) * frame.grid.tiles_x();
      const auto end = static_cast<uint32_t>(frame.grid.tiles_y() * (band + 1) / bands) * frame.grid.tiles_x();
      units.push_back({first, end - first, light, 1});
    }
  }
  return units;
}

namespace {

template <bool Referenced>
bool walk_through(const SliceRange& range, std::span<const uint8_t> coded, const TileGrid& grid,
                  const MaskReference* reference, std::span<uint64_t> words) {
  static thread_local Kit<Referenced> kit;
  kit.fit(grid);
  BinaryDecoder coder(coded);
  TileWalk walk(coder, kit.model, grid, kit.walk);
  const uint32_t end = range.first_tile + range.tile_count;
  for (uint32_t l = 0; l < range.light_count; ++l) {
    const uint32_t light = range.first_light + l;
    walk.begin({{},
                words.subspan(size_t{light} * grid.tile_count(), grid.tile_count()),
                reference ? &reference->rows(light) : nullptr,
                {}},
               range.first_tile);
    for (uint32_t next = range.first_tile; next < end;) {
      const uint32_t segment = std::min(end, segment_end(next, grid.tiles_x()));
      walk.segment(next, segment);
      next = segment;
    }
  }
  return coder.at_end();
}

}  // namespace

bool lacks_reference(std::span<const uint8_t> payload, const TileGrid& grid, const ReferenceShelf* references) {
  if (payload.size() < kReferencedHead || payload[0] != static_cast<uint8_t>(Form::referenced)) return false;
  const MaskReference* reference = references ? references->find(FrameId{read_u32(&payload[1])}) : nullptr;
  return !reference || reference->grid() != grid || reference->checksum() != read_u32(&payload[5]);
}

Result<void> decode(const SliceRange& range, std::span<const uint8_t> payload, const TileGrid& grid,
                    const ReferenceShelf* references, std::span<uint64_t> words) {
  if (payload.empty()) return Error{"a slice without payload"};
  bool exact = false;
  if (payload[0] == static_cast<uint8_t>(Form::alone)) {
    exact = walk_through<false>(range, payload.subspan(1), grid, nullptr, words);
  } else if (payload[0] == static_cast<uint8_t>(Form::referenced) && payload.size() >= kReferencedHead) {
    if (lacks_reference(payload, grid, references)) return Error{"a slice refers to a frame that is not here"};
    const MaskReference* reference = references->find(FrameId{read_u32(&payload[1])});
    exact = walk_through<true>(range, payload.subspan(kReferencedHead), grid, reference, words);
  } else {
    return Error{"a slice's payload is of unknown form"};
  }
  if (!exact) return Error{"a slice's size does not match its tiles"};
  return {};
}

}  // namespace gnomon::protocol::context
