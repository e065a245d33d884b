// References over links that lose and mix up: what arrives is exact, whatever the link does.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>

#include "client/view/client_renderer.h"
#include "gpu/passes/passes.h"
#include "gpu/picture/blocking_frame.h"
#include "gpu/wire/translate.h"
#include "tests/system/e2e/bad_link.h"
#include "tests/system/e2e/flier.h"

namespace gnomon::tests {
namespace {

constexpr client::ViewSize kSize{.width = 320, .height = 180};
constexpr auto kEvery = std::chrono::milliseconds(50);  // a camera

struct Seen {
  protocol::CameraView camera;
  std::vector<uint64_t> words;
  bool context = false;  // in tiles_context alone
  size_t payload_bytes = 0;
  size_t answer = 0;  // among all answers, those with tiles missing too
};

// A client that flies on evenly, 33 ms of the path a camera, and asks at a steady pace, whatever is lost. What it got
// whole is kept.
class Watcher {
 public:
  Watcher(client::Loop& loop, const Daemon& daemon, const client::Address& server,
          const std::vector<protocol::CodecId>& codecs, const client::ViewSize& size = kSize)
      : loop_(loop),
        path_(living_room_path()),
        size_(size),
        pace_(loop, [this] { ask(); }),
        stream_(loop, options(daemon, server, codecs, size),
                {.answer =
                     [this](const client::Answer& answer) {
                       whole_.push_back(answer.mask.complete());
                       if (answer.mask.complete())
                         seen_.push_back({answer.camera, answer.mask.words, answer.mask.referable,
                                          answer.mask.payload_bytes, whole_.size() - 1});
                     },
                 .opened = [this] { ask(); }}) {}

  bool watch(size_t frames) {
    return watch_until([&] { return seen_.size() >= frames; });
  }
  bool watch_until(const std::function<bool()>& done) { return loop_.run_until(Clock::now() + kPatience, done); }
  size_t in_context() const {
    return static_cast<size_t>(std::count_if(seen_.begin(), seen_.end(), [](const Seen& s) { return s.context; }));
  }
  const std::vector<Seen>& seen() const { return seen_; }
  const std::vector<bool>& whole() const { return whole_; }  // every answer
  const client::StreamCounters& counters() const { return stream_.counters(); }

 private:
  static client::StreamOptions options(const Daemon& daemon, const client::Address& server,
                                       const std::vector<protocol::CodecId>& codecs, const client::ViewSize& size) {
    client::StreamOptions options;
    options.connect.server = server;
    options.connect.trust.pin = daemon.pin();
    options.connect.timeout = kPatience;
    options.connect.hello.tenant = "studio";
    options.connect.hello.scene = "living_room";
    options.connect.hello.width = static_cast<uint16_t>(size.width);
    options.connect.hello.height = static_cast<uint16_t>(size.height);
    options.connect.hello.codecs = codecs;
    return options;
  }
  void ask() {
    stream_.ask(client::view_of(path_.at(0.033 * static_cast<double>(asked_++)), size_));
    pace_.arm(Clock::now() + kEvery);
  }

  client::Loop& loop_;
  client::CameraPath path_;
  client::ViewSize size_;
  client::Timer pace_;
  size_t asked_ = 0;
  std::vector<Seen> seen_;
  std::vector<bool> whole_;
  client::VisibilityStream stream_;
};

// Bits that differ from what the renderer makes of the same cameras, where they matter.
class Judge {
 public:
  explicit Judge(const client::ViewSize& size = kSize) {
    gpu::RendererOptions options;
    options.device = "cpu";
    options.tracer_options.cache_folder = kept_light_buffers();  // of those that e2e_exact checks
    auto made = gpu::BlockingFrame::create(options, {"gbuffer", "trace", "readback_masks", "readback_valid_bits"},
                                           scenes::load_scene(living_room_file()).value());
    EXPECT_TRUE(made) << made.error().message;
    frame_ = std::move(*made);
    grid_ = frame_->reserve(size.width, size.height).value();
  }
  size_t wrong_bits(const Seen& seen) {
    EXPECT_TRUE(frame_->render(gpu::from_wire(seen.camera), grid_));
    const auto words = words_of(gpu::resource::kHostMasks), valid_bits = words_of(gpu::resource::kHostValidBits);
    EXPECT_EQ(seen.words.size(), words.size());
    size_t wrong = 0;
    for (size_t i = 0; i < words.size(); ++i)
      wrong += static_cast<size_t>(std::popcount((words[i] ^ seen.words[i]) & valid_bits[i]));
    return wrong;
  }

 private:
  std::span<const uint64_t> words_of(std::string_view resource) {
    return {reinterpret_cast<const uint64_t*>(frame_->host(resource).data()), grid_.word_count()};
  }

  std::unique_ptr<gpu::BlockingFrame> frame_;
  TileGrid grid_;
};

// Slices refer to frames that the client may have lost parts of, got late, or twice.
TEST(CodecLink, ReferencesSurviveLossAndReordering) {
  constexpr size_t kFrames = 60;
  Judge judge;
  const Daemon daemon;
  size_t bytes = 0, bytes_alone = 0;
  {
    client::Loop loop;
    Relay relay(daemon, {"--delay", "5ms", "--loss", "8%", "--reorder", "10%", "--reorder_by", "15ms",
                         "--duplicate", "2%", "--seed", "5"});
    Watcher watcher(loop, daemon, relay.address(), {protocol::CodecId::tiles_context});
    ASSERT_TRUE(watcher.watch(kFrames)) << relay.process().output();
    EXPECT_EQ(watcher.counters().invalid_slices, 0u);
    for (size_t i = 0; i < kFrames; ++i) {
      ASSERT_EQ(judge.wrong_bits(watcher.seen()[i]), 0u) << "frame " << i;
      EXPECT_TRUE(watcher.seen()[i].context);
      bytes += watcher.seen()[i].payload_bytes;
    }
    EXPECT_TRUE(eventually([&] {
      loop.poll();
      return daemon.metric("gnomon_datagrams_lost_total") > 0;
    }));
  }
  client::Loop loop;
  Watcher watcher(loop, daemon, daemon.address(), {protocol::CodecId::tiles_lz4});
  ASSERT_TRUE(watcher.watch(kFrames));
  for (size_t i = 0; i < kFrames; ++i) bytes_alone += watcher.seen()[i].payload_bytes;
  std::printf("%zu bytes a frame in tiles_context over the lossy link, %zu in tiles_lz4\n", bytes / kFrames,
              bytes_alone / kFrames);
  EXPECT_LT(bytes, bytes_alone / 2);
}

// A link that carries half of the frames that are asked for in the first codec, and all of them in the denser one.
TEST(CodecLink, TheControllerSwitchesToTheDenserCodecAndLosesNoFrame) {
  constexpr client::ViewSize kLarger{.width = 480, .height = 270};
  const Daemon daemon;
  client::Loop loop;
  Relay relay(daemon, {"--delay", "10ms", "--down", "rate=400kbit,queue=300ms"});
  Watcher watcher(loop, daemon, relay.address(), {protocol::CodecId::tiles_lz4, protocol::CodecId::tiles_context},
                  kLarger);
  ASSERT_TRUE(watcher.watch_until([&] { return watcher.in_context() >= 20; }))
      << watcher.seen().size() << " frames, " << watcher.in_context() << " in the denser codec";
  EXPECT_FALSE(watcher.seen().front().context);
  EXPECT_EQ(watcher.counters().invalid_slices, 0u);
  const auto switched =
      std::find_if(watcher.seen().begin(), watcher.seen().end(), [](const Seen& s) { return s.context; });
  // Until the controller has found the link's rate it overruns it; from shortly before the switch on nothing is missing.
  for (size_t i = switched->answer - std::min<size_t>(switched->answer, 1); i < watcher.whole().size(); ++i) {
    EXPECT_TRUE(watcher.whole()[i]) << "answer " << i << ", the first in the denser codec is " << switched->answer
                                    << ", cut short by the daemon: "
                                    << daemon.metric("gnomon_frames_dropped_total", {"link_too_slow"});
  }
  Judge judge(kLarger);
  for (const Seen& seen : watcher.seen()) ASSERT_EQ(judge.wrong_bits(seen), 0u);
}

}  // namespace
}  // namespace gnomon::tests
