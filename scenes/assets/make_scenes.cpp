// gnomon-make-scenes OUTDIR: writes the built-in scenes living_room.glb and temple.glb.
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <system_error>

#include "scenes/assets/built_in.h"
#include "scenes/assets/glb_writer.h"

namespace {

namespace assets = gnomon::scenes::assets;

bool write(const std::filesystem::path& folder, const assets::Stage& stage) {
  const std::vector<uint8_t> bytes = assets::to_glb(stage);
  const std::filesystem::path file = folder / (stage.name + ".glb");
  std::ofstream out(file, std::ios::binary | std::ios::trunc);
  out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  out.close();
  if (!out) {
    std::fprintf(stderr, "gnomon-make-scenes: cannot write %s\n", file.c_str());
    return false;
  }
  std::printf("%s: %llu triangles, %zu lights, %.0f s flight, %zu bytes\n", file.c_str(),
              static_cast<unsigned long long>(stage.triangle_count()), stage.lights.size(),
              static_cast<double>(stage.flight.back().seconds), bytes.size());
  return true;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2 || argv[1][0] == '-') {
    std::fprintf(stderr, "usage: gnomon-make-scenes OUTDIR\n");
    return 2;
  }
  const std::filesystem::path folder = argv[1];
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) {
    std::fprintf(stderr, "gnomon-make-scenes: cannot make %s: %s\n", folder.c_str(), error.message().c_str());
    return 1;
  }
  return write(folder, assets::make_living_room()) && write(folder, assets::make_temple()) ? 0 : 1;
}
