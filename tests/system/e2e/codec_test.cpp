// What frames take on the real daemon's wire is what the benchmark says, and no codec loses one.
#include <gtest/gtest.h>

#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>

#include "tests/system/e2e/daemon.h"
#include "tests/system/e2e/flier.h"

namespace gnomon::tests {
namespace {

constexpr client::ViewSize kCodecSize{.width = 640, .height = 360};
constexpr size_t kCodecFrames = 4;

// Bytes of a frame's datagrams by codec, as the benchmark says.
std::map<std::string, double> benchmark() {
  const TemporaryFolder folder;
  const auto json = folder.path() / "codec.json";
  const auto [status, output] =
      run("gnomon-bench", {"codec", "--scene", "living_room", "--size", "640x360", "--frames",
                           std::to_string(kCodecFrames), "--device", "cpu", "--json", json.string()});
  EXPECT_EQ(status, 0) << output;
  std::map<std::string, double> bytes;
  if (status != 0) return bytes;
  const auto report = nlohmann::json::parse(read_file(json));
  for (const auto& row : report["rows"])
    if (!row["wire_bytes_per_frame"].is_null()) bytes[row["codec"]] = row["wire_bytes_per_frame"];
  return bytes;
}

// The same cameras through the daemon, one after the other. Slices that were sent again do not count.
double served(protocol::CodecId codec) {
  const Daemon daemon;
  client::Loop loop;
  const client::CameraPath path = living_room_path();
  size_t answered = 0, asked = 0;
  client::StreamOptions options;
  options.connect.server = daemon.address();
  options.connect.trust.pin = daemon.pin();
  options.connect.timeout = kPatience;
  options.connect.hello.tenant = "studio";
  options.connect.hello.scene = "living_room";
  options.connect.hello.width = kCodecSize.width;
  options.connect.hello.height = kCodecSize.height;
  options.connect.hello.codecs = {codec};
  options.keep_references = false;  // cameras are seconds apart
  options.patience = options.answer_timeout = kPatience;
  double bytes = 0;
  client::VisibilityStream* stream = nullptr;
  const auto ask = [&] {
    const double seconds = path.duration_seconds() * (static_cast<double>(asked++) + 0.5) / kCodecFrames;
    stream->ask(client::view_of(path.at(seconds), kCodecSize));
  };
  client::VisibilityStream made(
      loop, options,
      {.answer =
           [&](const client::Answer& answer) {
             EXPECT_TRUE(answer.mask.complete());
             constexpr size_t kOverhead = protocol::kMaxDatagramBytes - protocol::kMaxSlicePayloadBytes;
             bytes += static_cast<double>(answer.mask.payload_bytes + answer.mask.slice_count * kOverhead);
             if (++answered < kCodecFrames) ask();
           },
       .opened = [&] { ask(); }});
  stream = &made;
  EXPECT_TRUE(loop.run_until(Clock::now() + kPatience, [&] { return answered == kCodecFrames; }));
  EXPECT_GT(
      daemon.metric("gnomon_codec_bytes_sent_total", {"codec=\"" + std::string(protocol::to_string(codec)) + "\""}),
      0);
  return bytes / kCodecFrames;
}

TEST(Codec, TheWireCarriesWhatTheBenchmarkSays) {
  const auto expected = benchmark();
  for (const protocol::CodecId codec : protocol::kCodecs) {
    const std::string name = protocol::to_string(codec);
    ASSERT_TRUE(expected.contains(name)) << name;
    const double bytes = served(codec);
    std::printf("%s: %.0f bytes a frame on the wire, %.0f in the benchmark\n", name.c_str(), bytes,
                expected.at(name));
    EXPECT_NEAR(bytes, expected.at(name), 0.05 * expected.at(name)) << name;
  }
}

// Frames one after the other along the path, each referring to one before: exact where it matters, none lost.
TEST(Codec, LoadInEveryCodecLosesNothing) {
  for (const protocol::CodecId codec : protocol::kCodecs) {
    const Daemon daemon;
    const auto [status, output] =
        run("gnomon-load",
            {"--server", daemon.server(), "--pin", daemon.pin(), "--scene", "living_room", "--size", "320x180",
             "--seconds", "3", "--tenant", "studio::2", "--codec", protocol::to_string(codec)});
    EXPECT_EQ(status, 0) << output;
    const std::string label = "codec=\"" + std::string(protocol::to_string(codec)) + "\"";
    EXPECT_GT(daemon.metric("gnomon_codec_bytes_sent_total", {label}), 0);
    EXPECT_GT(daemon.metric("gnomon_visibility_buffers_total"), 3);
  }
}

}  // namespace
}  // namespace gnomon::tests
