// Writes the seed corpus: what a right peer would send. Run it after the protocol has changed and commit the result.
//
//   fuzz_make_seeds tests/fuzz/corpus
#include <filesystem>
#include <fstream>
#include <random>

#include "common/packed_mask.h"
#include "gpu/builds/packed_builds.h"
#include "protocol/codec.h"
#include "protocol/feedback.h"
#include "protocol/parity.h"
#include "scenes/packed/packed_scene.h"
#include "tests/fuzz/small_mesh.h"
#include "tests/unit/protocol/random_messages.h"

namespace {

namespace fs = std::filesystem;
using namespace gnomon;
using Bytes = std::vector<uint8_t>;

void write(const fs::path& folder, const std::string& name, const Bytes& bytes) {
  fs::create_directories(folder);
  std::ofstream(folder / name, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

void put_number(Bytes& out, uint32_t value) {
  out.push_back(static_cast<uint8_t>(value >> 8));
  out.push_back(static_cast<uint8_t>(value));
}

void control(const fs::path& folder, tests::Random& random) {
  for (size_t type = 0; type < tests::kMessageTypes; ++type) {
    Bytes bytes;
    put_number(bytes, 99);
    const Bytes message = protocol::encode(tests::random_message(type, random));
    bytes.insert(bytes.end(), message.begin(), message.end());
    write(folder, "message-" + std::to_string(type), bytes);
  }
}

void datagrams(const fs::path& folder, tests::Random& random) {
  Bytes update, feedback, parity, header(protocol::kHeaderBytes + 60);
  protocol::append_camera_update(update, tests::random_update(random));
  protocol::Feedback arrivals;
  arrivals.count = 40;
  for (size_t i = 0; i < arrivals.count; ++i) arrivals.ages[i] = static_cast<uint16_t>(random());
  protocol::append_feedback(feedback, arrivals);
  protocol::append_parity(parity, {FrameId{7}, 20, 2, 1, 0, 0}, Bytes(90, 0x55));
  protocol::write_header(std::span(header).first<protocol::kHeaderBytes>(),
                         {protocol::DatagramKind::camera_update, 0, SessionId{77}, 1});
  write(folder, "camera_update", update);
  write(folder, "feedback", feedback);
  write(folder, "parity", parity);
  write(folder, "sealed", header);
}

// What `write_to` writes into a file; here into memory.
template <class Write>
void write_file(const fs::path& folder, const std::string& name, Write write_to) {
  char* data = nullptr;
  size_t size = 0;
  std::FILE* file = open_memstream(&data, &size);
  write_to(file);
  std::fclose(file);
  write(folder, name, Bytes(data, data + size));
  std::free(data);
}

void write_outcome(const fs::path& folder, const std::string& name, const Result<scenes::ScenePtr>& scene) {
  write_file(folder, name, [&](std::FILE* file) { (void)scenes::write_outcome(scene, file); });
}

void packed_builds(const fs::path& folder) {
  const scenes::WorldMesh mesh = fuzz::small_mesh();
  write_file(folder, "hierarchy",
             [&](std::FILE* file) { (void)gpu::write_outcome(gpu::builds_here()->bvh(mesh), file); });
  write_file(folder, "light_buffer", [&](std::FILE* file) {
    gpu::light_buffer::LightBuffer buffer;
    buffer.grid = {0, 0};
    buffer.leaves.resize(2);
    buffer.leaves[1].count = 2;
    buffer.entries = {{0x7e000000, 0x7f8003ff, 1}, {0x7d000000, 0x7f8003ff, 7}};
    (void)gpu::write_outcome(Result<gpu::light_buffer::LightBuffer>(buffer), file);
  });
  write_file(folder, "task", [&](std::FILE* file) {
    gpu::BuildTask task;
    task.mesh = &mesh;
    scenes::PackWriter writer(file);
    gpu::write(writer, task);
  });
}

// A scene with one of everything.
void packed_scenes(const fs::path& folder) {
  const auto scene = std::make_shared<scenes::Scene>();
  scenes::Channel slide;
  slide.times = {0, 1};
  slide.values = {glm::vec4(0), glm::vec4(1)};
  scene->textures.emplace_back().rgba = {255, 255, 255, 255};
  scene->textures[0].width = scene->textures[0].height = 1;
  scene->materials.emplace_back().base_color_texture = 0;
  scenes::Primitive& triangle = scene->meshes.emplace_back().primitives.emplace_back();
  triangle.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  triangle.triangles = {{0, 1, 2}};
  scene->moving_nodes.emplace_back().channels = {slide};
  scene->instances.emplace_back().moved_by = 0;
  scene->lights.emplace_back().name = "lamp";
  scene->cameras.emplace_back().name = "eye";
  scenes::CameraPath& path = scene->paths.emplace_back();
  path.chain.emplace_back();
  path.channels = {slide};
  scene->period = std::chrono::seconds(1);
  scene->triangle_count = 1;
  write_outcome(folder, "scene", scenes::ScenePtr(scene));
  write_outcome(folder, "reason", Error{"it has too many triangles"});
}

// Straight borders and some noise.
std::vector<uint64_t> mask_of(const TileGrid& grid, tests::Random& random) {
  std::vector<uint64_t> words(grid.word_count());
  for (size_t i = 0; i < words.size(); ++i) {
    words[i] = i % 5 == 0 ? 0x0f0f1f1f3f3f7f7f : i % 7 == 0 ? random() : i % 2 ? ~uint64_t{0} : 0;
  }
  return words;
}

void slices(const fs::path& folder, tests::Random& random) {
  const TileGrid grid{120, 64, 2};
  const auto words = mask_of(grid, random);
  protocol::FrameEncoder encoder;
  for (const protocol::CodecId codec : protocol::kCodecs) {
    protocol::EncodedMask frame;
    if (!encoder.encode(TileMaskView{grid, words}, codec, protocol::kMinPayloadBytes, frame)) continue;
    for (size_t i = 0; i < std::min<size_t>(3, frame.slices.size()); ++i) {
      const protocol::SliceHeader& header = frame.slices[i];
      Bytes bytes;
      for (const uint32_t number :
           {grid.width - 1, grid.height - 1, grid.planes - 1, uint32_t(header.codec), header.first_tile,
            header.tile_count, uint32_t{header.first_light}, uint32_t{header.light_count}}) {
        put_number(bytes, number);
      }
      const auto payload = frame.payload(i);
      bytes.insert(bytes.end(), payload.begin(), payload.end());
      write(folder, "codec" + std::to_string(static_cast<int>(codec)) + "-" + std::to_string(i), bytes);
    }
  }
}

void masks(const fs::path& folder, tests::Random& random) {
  for (int i = 0; i < 4; ++i) {
    Bytes bytes(200 + random() % 600);
    for (uint8_t& byte : bytes) byte = static_cast<uint8_t>(random());
    write(folder, "mask-" + std::to_string(i), bytes);
  }
}

// Steps of tests/fuzz/link.cpp: a frame, some time, and what was sent is said to have arrived, several times over.
void links(const fs::path& folder, tests::Random& random) {
  for (int i = 0; i < 4; ++i) {
    Bytes bytes;
    put_number(bytes, static_cast<uint32_t>(i % 2));
    for (int round = 0; round < 12; ++round) {
      for (const uint32_t number : {2u, 30u, 0u, 800u, 0u, 9000u}) put_number(bytes, number);  // a frame, 9 ms
      if (round % 3 == 2) put_number(bytes, static_cast<uint32_t>(3 + i % 2));  // a number left out, a Pong
      put_number(bytes, 6);                                                     // a report
      put_number(bytes, i == 3 ? 4u : 1u);
      put_number(bytes, i == 3 ? static_cast<uint32_t>(random() % 1024) : static_cast<uint32_t>(1 + round * 4));
      put_number(bytes, 1);
      put_number(bytes, static_cast<uint32_t>(random() % 1024));
      for (const uint32_t number : {0u, 0u, 4u, 5u}) put_number(bytes, number);
    }
    write(folder, "steps-" + std::to_string(i), bytes);
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const fs::path folder = argv[1];
  tests::Random random(12);
  control(folder / "control", random);
  datagrams(folder / "datagrams", random);
  slices(folder / "slices", random);
  masks(folder / "codecs", random);
  masks(folder / "parity", random);
  packed_scenes(folder / "packed_scene");
  packed_builds(folder / "packed_builds");
  links(folder / "link", random);
  return 0;
}
