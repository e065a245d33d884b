// What a process that reads scenes answers: a scene that keeps its promises, or an error.
#include "scenes/packed/packed_scene.h"

#include "scenes/packed/check.h"
#include "tests/fuzz/target.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace gnomon;
  const auto bytes = std::as_bytes(std::span(data, size));
  scenes::LoadLimits limits;
  limits.max_texels = 1 << 20;
  if (const auto scene = scenes::read_outcome(bytes, limits)) {
    fuzz::require(bool(scenes::check(**scene, limits)), "a scene that is taken is sound");
  }
  scenes::PackReader reader(bytes);
  scenes::LoadTask task;
  scenes::read(reader, task);
  return 0;
}
