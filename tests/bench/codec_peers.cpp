#include "tests/bench/codec_peers.h"

extern "C" {
#include <jbig.h>
}
#include <zstd.h>

#include <array>

namespace gnomon::bench {
namespace {

constexpr int kZstdLevel = 3;

class ZstdWords : public FrameCodec {
 public:
  ~ZstdWords() override {
    ZSTD_freeCCtx(compression_);
    ZSTD_freeDCtx(decompression_);
  }
  std::string name() const override { return "zstd3_words"; }
  void prepare(const TileGrid& grid, const PathSpot& spot) override {
    in_ = unpacked(spot.now.packed.view());
    out_.resize(grid.word_count());
    packed_.resize(ZSTD_compressBound(in_.size() * sizeof(uint64_t)));
  }
  CodedSize encode() override {
    size_ = ZSTD_compressCCtx(compression_, packed_.data(), packed_.size(), in_.data(),
                              in_.size() * sizeof(uint64_t), kZstdLevel);
    return {size_};
  }
  bool decode() override {
    const size_t size = out_.size() * sizeof(uint64_t);
    return ZSTD_decompressDCtx(decompression_, out_.data(), size, packed_.data(), size_) == size;
  }
  std::span<const uint64_t> words() override { return out_; }

 private:
  ZSTD_CCtx* compression_ = ZSTD_createCCtx();
  ZSTD_DCtx* decompression_ = ZSTD_createDCtx();
  std::vector<uint64_t> in_, out_;
  std::vector<uint8_t> packed_;
  size_t size_ = 0;
};

constexpr auto kMirrored = [] {
  std::array<uint8_t, 256> mirrored{};
  for (unsigned byte = 0; byte < 256; ++byte)
    for (unsigned bit = 0; bit < 8; ++bit) mirrored[byte] |= static_cast<uint8_t>((byte >> bit & 1) << (7 - bit));
  return mirrored;
}();

// Rows of eight pixels a byte, the leftmost in the highest bit, of whole tiles.
void to_rows(std::span<const uint64_t> words, const TileGrid& grid, std::vector<uint8_t>& rows) {
  rows.resize(words.size() * 8);
  for (size_t i = 0; i < words.size(); ++i)
    for (size_t y = 0; y < 8; ++y)
      rows[(i / grid.tiles_x() * 8 + y) * grid.tiles_x() + i % grid.tiles_x()] =
          kMirrored[words[i] >> 8 * y & 0xff];
}

void from_rows(const uint8_t* rows, const TileGrid& grid, std::span<uint64_t> words) {
  for (size_t i = 0; i < words.size(); ++i) {
    words[i] = 0;
    for (size_t y = 0; y < 8; ++y)
      words[i] |= uint64_t{kMirrored[rows[(i / grid.tiles_x() * 8 + y) * grid.tiles_x() + i % grid.tiles_x()]]}
                  << 8 * y;
  }
}

class Jbig1 : public FrameCodec {
 public:
  std::string name() const override { return "jbig1"; }
  void prepare(const TileGrid& grid, const PathSpot& spot) override {
    grid_ = grid;
    const std::vector<uint64_t> words = unpacked(spot.now.packed.view());
    planes_.resize(grid.planes);
    for (uint32_t light = 0; light < grid.planes; ++light)
      to_rows(std::span(words).subspan(size_t{light} * grid.tile_count(), grid.tile_count()), grid, planes_[light]);
  }
  CodedSize encode() override {
    CodedSize size;
    coded_.resize(planes_.size());
    for (size_t light = 0; light < planes_.size(); ++light) {
      coded_[light].clear();
      unsigned char* picture = planes_[light].data();
      jbg_enc_state state;
      jbg_enc_init(&state, grid_.tiles_x() * 8, grid_.tiles_y() * 8, 1, &picture, append, &coded_[light]);
      jbg_enc_layers(&state, 0);
      jbg_enc_options(&state, JBG_SMID | JBG_ILEAVE, JBG_TPBON, grid_.tiles_y() * 8, 8, 0);
      jbg_enc_out(&state);
      jbg_enc_free(&state);
      size.bytes += coded_[light].size();
    }
    return size;
  }
  bool decode() override {
    decoded_.resize(planes_.size());
    for (size_t light = 0; light < coded_.size(); ++light) {
      jbg_dec_state state;
      jbg_dec_init(&state);
      size_t read = 0;
      const int result = jbg_dec_in(&state, coded_[light].data(), coded_[light].size(), &read);
      if (result == JBG_EOK)
        decoded_[light].assign(jbg_dec_getimage(&state, 0), jbg_dec_getimage(&state, 0) + jbg_dec_getsize(&state));
      jbg_dec_free(&state);
      if (result != JBG_EOK) return false;
    }
    return true;
  }
  std::span<const uint64_t> words() override {
    words_.resize(grid_.word_count());
    for (size_t light = 0; light < decoded_.size(); ++light)
      from_rows(decoded_[light].data(), grid_,
                std::span(words_).subspan(light * grid_.tile_count(), grid_.tile_count()));
    return words_;
  }

 private:
  static void append(unsigned char* start, size_t size, void* out) {
    auto& bytes = *static_cast<std::vector<uint8_t>*>(out);
    bytes.insert(bytes.end(), start, start + size);
  }

  TileGrid grid_;
  std::vector<std::vector<uint8_t>> planes_, coded_, decoded_;
  std::vector<uint64_t> words_;
};

}  // namespace

std::unique_ptr<FrameCodec> make_zstd_words() { return std::make_unique<ZstdWords>(); }
std::unique_ptr<FrameCodec> make_jbig1() { return std::make_unique<Jbig1>(); }

}  // namespace gnomon::bench
