// The pack that browsers get of a scene, and what compressing it costs.
//
//   web_make_pack SCENE.glb [PACK]      writes the pack; without PACK, prints bytes and milliseconds of each quality
#include <chrono>
#include <cstdio>

#include "common/brotli.h"
#include "scenes/loader.h"
#include "scenes/web_pack.h"

namespace {

using namespace gnomon;

template <class Work>
auto timed(Work work, double& milliseconds) {
  const auto start = std::chrono::steady_clock::now();
  auto result = work();
  milliseconds = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  return result;
}

int fail(const Error& error) {
  std::fprintf(stderr, "web_make_pack: %s\n", error.message.c_str());
  return 1;
}

int write(const std::vector<std::byte>& pack, const char* file) {
  std::FILE* const out = std::fopen(file, "wb");
  const bool written = out && std::fwrite(pack.data(), 1, pack.size(), out) == pack.size();
  return (out && std::fclose(out) == 0 && written) ? 0 : fail({std::string(file) + " cannot be written"});
}

int print_costs(const std::vector<std::byte>& pack) {
  for (const int quality : {1, 4, 5, 6, 7, 8, 9, 10, 11}) {
    double milliseconds = 0;
    const auto packed = timed([&] { return brotli(pack, quality); }, milliseconds);
    if (!packed) return fail(packed.error());
    std::printf("quality %2d: %9zu bytes, %8.0f ms\n", quality, packed->size(), milliseconds);
    std::fflush(stdout);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) return fail({"which scene?"});
  const auto scene = scenes::load_with_geometry(argv[1], {}, {}, scenes::Colours::encoded);
  if (!scene) return fail(scene.error());
  double milliseconds = 0;
  const auto pack = timed([&] { return scenes::web_pack(**scene); }, milliseconds);
  if (!pack) return fail(pack.error());
  if (argc > 2) return write(*pack, argv[2]);
  std::printf("%s: %zu bytes, %.0f ms to make\n", argv[1], pack->size(), milliseconds);
  return print_costs(*pack);
}
