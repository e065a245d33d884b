// gnomon-train-nets: makes protocol/context/net_weights.inc from masks along scenes' camera paths.
//
//   gnomon-train-nets --scene living_room temple oa_minia country_kitchen --out protocol/context/net_weights.inc
//
// Walks the masks as the encoder does, records each question to the nets with its right answer, and fits the nets by
// stochastic gradient descent. The same masks give the same weights.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <random>

#include "protocol/context/context_slices.h"
#include "protocol/context/motion_search.h"
#include "protocol/context/tile_walk.h"
#include "tests/bench/path_masks.h"
#include "tests/bench/report.h"

namespace gnomon::bench {
namespace {

using namespace protocol::context;

// One question to a net: its inputs, and the right answer for each output, -1 if that was not asked.
template <class Net>
struct Answered {
  typename Net::Inputs inputs;
  std::array<int8_t, Net::kOutputs> answers;
};

// Draws the same number of questions from each scene.
template <class Net>
class Questions {
 public:
  void add(const Answered<Net>& question) {
    ++met_;
    if (kept_.size() < kMostOfAScene) {
      kept_.push_back(question);
    } else if (const uint64_t place = random_() % met_; place < kMostOfAScene) {
      kept_[place] = question;
    }
  }
  void end_scene() {
    all_.insert(all_.end(), kept_.begin(), kept_.end());
    kept_.clear();
    met_ = 0;
  }
  std::vector<Answered<Net>>& shuffled() {
    std::shuffle(all_.begin(), all_.end(), random_);
    return all_;
  }

 private:
  static constexpr size_t kMostOfAScene = 1'500'000;
  std::vector<Answered<Net>> all_, kept_;
  uint64_t met_ = 0;
  std::mt19937_64 random_{1};
};

struct Copier {
  static constexpr bool kDecodes = false;
};

// Replaces SliceModel in the encoder.
template <bool Referenced>
class Recorder {
 public:
  static constexpr bool kReferenced = Referenced;
  using Windows = RowWindows<Referenced>;
  using Surroundings = TileSurroundings<Referenced>;

  Questions<typename Windows::Pixels> pixels;
  Questions<typename Windows::Runs> runs;
  Questions<typename Surroundings::Classes> classes;

  bool pixel(Copier&, bool bit, const Windows& windows, int at) {
    pixels.add({windows.about_pixel(at).inputs, {static_cast<int8_t>(bit)}});
    return bit;
  }
  int run(Copier&, int kept, const Windows& windows, int at, int length) {
    runs.add({windows.about_run(at, length).inputs, {static_cast<int8_t>(kept < length)}});
    return kept;
  }
  uint8_t tile(Copier&, PackedClass tile_class, const Surroundings& around) {
    const auto inputs = around.question().inputs;
    if (tile_class == PackedClass::free) {
      classes.add({inputs, {0, -1}});
      return around.west == kLit ? kLit : kDark;
    }
    const bool mixed = tile_class == PackedClass::mixed, lit = tile_class == PackedClass::lit;
    classes.add({inputs, {static_cast<int8_t>(mixed), mixed ? int8_t{-1} : static_cast<int8_t>(lit)}});
    return mixed ? kMixed : lit ? kLit : kDark;
  }
  uint32_t quiet_tiles(Copier&, uint32_t kept, bool, uint32_t) { return kept; }
  uint8_t odd_tile(Copier&, PackedClass tile_class, bool around) {
    return tile_class == PackedClass::mixed ? kMixed : around ? kDark : kLit;
  }
  Motion motion(Copier&, Motion motion, Motion predicted) { return motion == kAnyMotion ? predicted : motion; }

  void end_scene() {
    pixels.end_scene();
    runs.end_scene();
    classes.end_scene();
  }
};

constexpr uint32_t kRowsOfASlice = 20;  // about, of tiles

template <bool Referenced>
void record(const PathFrame& frame, const protocol::MaskReference* reference, Recorder<Referenced>& recorder) {
  FrameTiles tiles;
  tiles.take(frame.packed.view());
  tiles.refer_to(reference, frame.camera);
  const TileGrid& grid = tiles.grid;
  WalkMemory memory;
  memory.rows.reset(grid.tiles_x(), grid.tiles_y());
  Copier coder;
  TileWalk walk(coder, recorder, grid, memory);
  std::vector<Motion> motions(grid.tile_count());
  for (uint32_t light = 0; light < grid.planes; ++light) {
    const size_t first = size_t{light} * grid.tile_count();
    const LightTiles of_light{std::span(tiles.classes).subspan(first, grid.tile_count()),
                              std::span(tiles.words).subspan(first, grid.tile_count()),
                              reference ? &reference->rows(light) : nullptr, motions};
    if (reference)
      find_motions(grid, of_light, tiles.camera ? &*tiles.camera : nullptr,
                   {0, (grid.tiles_y() + kBlock - 1) / kBlock}, motions);
    for (uint32_t next = 0; next < grid.tile_count();) {
      if (next % (kRowsOfASlice * grid.tiles_x()) == 0) walk.begin(of_light, next);
      const uint32_t end = segment_end(next, grid.tiles_x());
      walk.segment(next, end);
      next = end;
    }
  }
}

// A net in floats.
template <class Net>
class Trainee {
 public:
  Trainee() {
    std::mt19937 random(1);
    std::normal_distribution<float> normal(0, 0.25f);
    for (size_t part = 0; part < Net::kParts; ++part) {
      parts_[part].rows.resize(Net::kBits[part]);
      for (Units& row : parts_[part].rows)
        for (float& weight : row) weight = normal(random);
      for (auto& output : parts_[part].outputs)
        for (float& weight : output) weight = normal(random);
    }
  }

  void learn(const Answered<Net>& question, float rate) {
    std::array<float, Net::kOutputs> sums = biases_;
    for (size_t part = 0; part < Net::kParts; ++part) parts_[part].say(question.inputs[part], sums);
    std::array<float, Net::kOutputs> errors{};
    for (size_t o = 0; o < Net::kOutputs; ++o) {
      if (question.answers[o] < 0) continue;
      errors[o] = (static_cast<float>(question.answers[o]) - 1 / (1 + std::exp(-sums[o]))) * rate;
      biases_[o] += errors[o];
    }
    for (size_t part = 0; part < Net::kParts; ++part) parts_[part].learn(question.inputs[part], errors);
  }

  // The weights in the order in which Net reads them.
  std::vector<int> numbers() const {
    std::vector<int> all;
    const auto add = [&](float value, int bits) {
      all.push_back(
          std::clamp(static_cast<int>(std::lround(value * static_cast<float>(1 << bits))), -32767, 32767));
    };
    for (size_t part = 0; part < Net::kParts; ++part) {
      for (const Units& row : parts_[part].rows)
        for (const float weight : row) add(weight, kWeightBits);
      for (const float bias : parts_[part].biases) add(bias, kWeightBits);
      for (size_t o = 0; o < Net::kOutputs; ++o) {
        for (const float weight : parts_[part].outputs[o]) add(weight, kOutputBits);
        add(part == 0 ? biases_[o] : 0, kOutputBits);
      }
    }
    return all;
  }

 private:
  using Units = std::array<float, kHidden>;

  struct Part {
    std::vector<Units> rows;
    Units biases{}, units{};
    std::array<Units, Net::kOutputs> outputs{};

    void say(uint32_t inputs, std::array<float, Net::kOutputs>& sums) {
      units = biases;
      for (; inputs != 0; inputs &= inputs - 1) {
        const Units& row = rows[static_cast<size_t>(std::countr_zero(inputs))];
        for (size_t unit = 0; unit < kHidden; ++unit) units[unit] += row[unit];
      }
      for (float& unit : units) unit = std::max(unit, 0.0f);
      for (size_t o = 0; o < Net::kOutputs; ++o)
        for (size_t unit = 0; unit < kHidden; ++unit) sums[o] += units[unit] * outputs[o][unit];
    }
    void learn(uint32_t inputs, const std::array<float, Net::kOutputs>& errors) {
      Units back{};
      for (size_t o = 0; o < Net::kOutputs; ++o)
        for (size_t unit = 0; unit < kHidden; ++unit) {
          back[unit] += units[unit] > 0 ? errors[o] * outputs[o][unit] : 0;
          outputs[o][unit] += errors[o] * units[unit];
        }
      for (size_t unit = 0; unit < kHidden; ++unit) biases[unit] += back[unit];
      for (; inputs != 0; inputs &= inputs - 1) {
        Units& row = rows[static_cast<size_t>(std::countr_zero(inputs))];
        for (size_t unit = 0; unit < kHidden; ++unit) row[unit] += back[unit];
      }
    }
  };

  std::array<Part, Net::kParts> parts_;
  std::array<float, Net::kOutputs> biases_{};
};

template <class Net>
void train(const std::string& name, Questions<Net>& questions, int rounds, std::ofstream& out) {
  Trainee<Net> net;
  auto& all = questions.shuffled();
  say(name + ": " + std::to_string(all.size()) + " questions");
  const double total = static_cast<double>(all.size()) * rounds;
  double done = 0;
  for (int round = 0; round < rounds; ++round)
    for (const auto& question : all) net.learn(question, 0.0002f + 0.02f * static_cast<float>(1 - done++ / total));
  const std::vector<int> numbers = net.numbers();
  out << "constexpr int16_t " << name << "[" << numbers.size() << "] = {";
  for (size_t i = 0; i < numbers.size(); ++i) out << (i % 24 == 0 ? "\n    " : " ") << numbers[i] << ",";
  out << "\n};\n";
}

Result<void> train_all(const std::vector<std::string>& scenes, const PathPlan& plan, int rounds,
                       const std::string& file) {
  Recorder<false> alone;
  Recorder<true> referenced;
  for (const std::string& scene : scenes) {
    const auto masks = masks_along_path(scene, plan);
    if (!masks) return masks.error();
    for (const PathSpot& spot : masks->spots) {
      record(spot.now, nullptr, alone);
      for (const PathFrame& before : spot.before) {
        const std::vector<uint64_t> words = unpacked(before.packed.view());
        const protocol::MaskReference reference(FrameId{1}, {masks->grid, words}, before.camera);
        record(spot.now, &reference, referenced);
      }
    }
    alone.end_scene();
    referenced.end_scene();
  }
  std::ofstream out(file);
  out << "// Made by gnomon-train-nets (tests/bench/train_nets.cpp); net.h says what the numbers are.\n";
  train("kPixelWeights", alone.pixels, rounds, out);
  train("kReferencePixelWeights", referenced.pixels, rounds, out);
  train("kRunWeights", alone.runs, rounds, out);
  train("kReferenceRunWeights", referenced.runs, rounds, out);
  train("kClassWeights", alone.classes, rounds, out);
  train("kReferenceClassWeights", referenced.classes, rounds, out);
  if (out.flush()) return {};
  return Error{"cannot write " + file};
}

}  // namespace
}  // namespace gnomon::bench

int main(int argc, char** argv) {
  CLI::App app("Trains the nets of tiles_context.");
  std::vector<std::string> scenes;
  std::string size_text = "1920x1080", out;
  gnomon::bench::PathPlan plan{.spots = 11, .size = {}, .ages_ms = {33, 100}, .device = {}, .folder = {}};
  int rounds = 4;
  app.add_option("--scene", scenes, "built-in names or glTF files")->required();
  app.add_option("--size", size_text, "pixels of the pictures")->capture_default_str();
  app.add_option("--frames", plan.spots, "cameras along each scene's path")->capture_default_str();
  app.add_option("--rounds", rounds, "times that every question is learnt from")->capture_default_str();
  app.add_option("--masks", plan.folder, "keep the masks in this folder, and take them from there");
  app.add_option("--out", out, "the file to write")->required();
  CLI11_PARSE(app, argc, argv);
  const auto size = gnomon::bench::parse_size(size_text);
  if (size) plan.size = *size;
  const auto trained =
      size ? gnomon::bench::train_all(scenes, plan, rounds, out) : gnomon::Result<void>(size.error());
  if (trained) return 0;
  std::fprintf(stderr, "gnomon-train-nets: %s\n", trained.error().message.c_str());
  return 1;
}
