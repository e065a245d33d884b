// Suite "codec": bytes and milliseconds of every codec on the masks along scenes' camera paths, compared with general
// compression and JBIG1, on one core.
#include <algorithm>
#include <map>
#include <optional>

#include "common/clock.h"
#include "protocol/codec.h"
#include "tests/bench/codec_peers.h"
#include "tests/bench/codec_plot.h"
#include "tests/bench/path_masks.h"
#include "tests/bench/suites.h"

namespace gnomon::bench {
namespace {

using nlohmann::ordered_json;

constexpr int kRepeats = 4;  // of each frame; the fastest one counts

// Bytes beside a slice's payload: the datagram's header, the slice's header and the seal's tag.
constexpr size_t kDatagramOverhead = protocol::kMaxDatagramBytes - protocol::kMaxSlicePayloadBytes;

class OwnCodec : public FrameCodec {
 public:
  // `before`: the index of PathSpot::before that slices refer to.
  OwnCodec(protocol::CodecId codec, std::string name, std::optional<size_t> before = {})
      : codec_(codec), name_(std::move(name)), before_(before) {}
  std::string name() const override { return name_; }
  void prepare(const TileGrid& grid, const PathSpot& spot) override {
    grid_ = grid;
    spot_ = &spot;
    words_.resize(grid.word_count());
    references_.clear();
    if (!before_) return;
    const std::vector<uint64_t> words = unpacked(spot.before[*before_].packed.view());
    references_.add(std::make_shared<protocol::MaskReference>(kBefore, TileMaskView{grid, words},
                                                              spot.before[*before_].camera));
  }
  CodedSize encode() override {
    const auto done = encoder_.encode(spot_->now.packed.view(), codec_, protocol::kMaxSlicePayloadBytes, frame_,
                                      references_.find(kBefore), spot_->now.camera);
    if (!done) return {};
    return {frame_.bytes.size(), frame_.slices.size()};
  }
  bool decode() override {
    for (size_t i = 0; i < frame_.slices.size(); ++i)
      if (!protocol::decode_slice(frame_.slices[i], frame_.payload(i), grid_, words_, &references_)) return false;
    return true;
  }
  std::span<const uint64_t> words() override { return words_; }

 private:
  static constexpr FrameId kBefore{1};

  protocol::CodecId codec_;
  std::string name_;
  std::optional<size_t> before_;
  TileGrid grid_;
  const PathSpot* spot_ = nullptr;
  protocol::ReferenceShelf references_;
  protocol::FrameEncoder encoder_;
  protocol::EncodedMask frame_;
  std::vector<uint64_t> words_;
};

// Means over the frames.
struct Totals {
  double bytes = 0, wire_bytes = 0, slices = 0, encode_ms = 0, decode_ms = 0;
};

bool same_where_it_matters(std::span<const uint64_t> decoded, const PathFrame& frame) {
  for (size_t i = 0; i < decoded.size(); ++i)
    if (((decoded[i] ^ frame.words[i]) & frame.valid_bits[i]) != 0) return false;
  return true;
}

template <class Call>
double fastest_ms(Call call) {
  double best = 0;
  for (int i = 0; i < kRepeats; ++i) {
    const TimePoint start = Clock::now();
    call();
    const double took = to_milliseconds(Clock::now() - start);
    best = i == 0 ? took : std::min(best, took);
  }
  return best;
}

class CodecSuite : public Suite {
 public:
  void add_options(CLI::App& command) override {
    command.add_option("--scene", scenes_, "built-in name or glTF file; default: the built-in ones and Sponza");
    command.add_option("--size", size_text_, "pixels of the traced picture")->capture_default_str();
    command.add_option("--device", plan_.device, "index, type or part of the name");
    command.add_option("--frames", plan_.spots, "cameras along the scene's path")->capture_default_str();
    command.add_option("--masks", plan_.folder, "keep the masks in this folder, and take them from there");
    command.add_option("--plot", plot_,
                       "draw bytes against milliseconds into this file, .png or .svg (needs gnuplot)");
  }

  Result<Report> run() override {
    const auto size = parse_size(size_text_);
    if (!size) return size.error();
    plan_.size = *size;
    report_.suite = "codec";
    if (scenes_.empty()) scenes_ = usual_scenes();
    for (const std::string& scene : scenes_) {
      say("scene " + scene);
      const auto masks = masks_along_path(scene, plan_);
      if (!masks) return masks.error();
      report_.device = masks->device;
      report_.driver = masks->driver;
      if (auto measured = measure(*masks); !measured) return measured.error();
    }
    if (!plot_.empty())
      if (auto plotted = plot_codecs(points_, "one frame of " + size_text_ + " on one core", plot_); !plotted)
        return plotted.error();
    return std::move(report_);
  }

 private:
  static std::vector<std::string> usual_scenes() {
    std::vector<std::string> usual;
    const std::vector<std::string> all = default_scenes();
    for (const char* name : {"living_room", "temple", "sponza_crytek"}) {
      if (std::find(all.begin(), all.end(), name) != all.end()) {
        usual.emplace_back(name);
      } else {
        say("scene " + std::string(name) + ": skipped, it is not here");
      }
    }
    return usual;
  }

  std::vector<std::unique_ptr<FrameCodec>> codecs() const {
    std::vector<std::unique_ptr<FrameCodec>> all;
    all.push_back(std::make_unique<OwnCodec>(protocol::CodecId::raw32_lz4, "raw32_lz4"));
    all.push_back(std::make_unique<OwnCodec>(protocol::CodecId::tiles_lz4, "tiles_lz4"));
    all.push_back(std::make_unique<OwnCodec>(protocol::CodecId::tiles_context, "tiles_context"));
    for (size_t i = 0; i < plan_.ages_ms.size(); ++i) {
      std::string name("tiles_context, reference ");
      name.append(std::to_string(plan_.ages_ms[i])).append(" ms before");
      all.push_back(std::make_unique<OwnCodec>(protocol::CodecId::tiles_context, std::move(name), i));
    }
    all.push_back(make_zstd_words());
    all.push_back(make_jbig1());
    return all;
  }

  Result<void> measure(const PathMasks& masks) {
    std::map<std::string, Totals> totals;
    const auto all = codecs();
    for (const auto& codec : all) {
      auto measured = measure(*codec, masks);
      if (!measured) return measured.error();
      totals[codec->name()] = *measured;
    }
    for (const auto& codec : all) add_row(masks, codec->name(), totals);
    return {};
  }

  static Result<Totals> measure(FrameCodec& codec, const PathMasks& masks) {
    Totals totals;
    const double share = 1.0 / static_cast<double>(masks.spots.size());
    for (const PathSpot& spot : masks.spots) {
      codec.prepare(masks.grid, spot);
      CodedSize size;
      bool decoded = true;
      totals.encode_ms += share * fastest_ms([&] { size = codec.encode(); });
      totals.decode_ms += share * fastest_ms([&] { decoded = codec.decode() && decoded; });
      if (size.bytes == 0 || !decoded || !same_where_it_matters(codec.words(), spot.now))
        return Error{masks.scene + ": " + codec.name() + " does not give back what it was given"};
      totals.bytes += share * static_cast<double>(size.bytes);
      totals.slices += share * static_cast<double>(size.slices);
      totals.wire_bytes += share * static_cast<double>(size.bytes + size.slices * kDatagramOverhead);
    }
    return totals;
  }

  void add_row(const PathMasks& masks, const std::string& codec, const std::map<std::string, Totals>& totals) {
    const Totals& own = totals.at(codec);
    points_.push_back({masks.scene, codec, own.bytes, own.encode_ms, own.decode_ms});
    ordered_json row{{"scene", masks.scene},
                     {"codec", codec},
                     {"size", size_text_},
                     {"lights", masks.grid.planes},
                     {"bytes_per_frame", own.bytes},
                     {"wire_bytes_per_frame", nullptr},
                     {"slices", nullptr},
                     {"encode_ms", own.encode_ms},
                     {"decode_ms", own.decode_ms},
                     {"ratio_to_raw32_lz4", own.bytes / totals.at("raw32_lz4").bytes},
                     {"ratio_to_jbig1", own.bytes / totals.at("jbig1").bytes}};
    if (own.slices > 0) {
      row["wire_bytes_per_frame"] = own.wire_bytes;
      row["slices"] = own.slices;
    }
    report_.rows.push_back(std::move(row));
  }

  std::vector<std::string> scenes_;
  std::string size_text_ = "1920x1080", plot_;
  PathPlan plan_{.spots = 12, .size = {}, .ages_ms = {33, 100}, .device = {}, .folder = {}};
  std::vector<CodecPoint> points_;
  Report report_;
};

}  // namespace

std::unique_ptr<Suite> make_codec_suite() { return std::make_unique<CodecSuite>(); }

}  // namespace gnomon::bench
