// Slices of a group, some of them missing, and parity shards that may be anything; and parity that is right.
#include "protocol/parity.h"
#include "tests/fuzz/target.h"

namespace gnomon::fuzz {
namespace {

using namespace protocol;

void rebuild_from_anything(const Bodies& bodies, std::span<const uint8_t> input) {
  std::vector<ParityShard> shards;
  while (!input.empty() && shards.size() < kMaxGroupParity) {
    const auto index = static_cast<uint8_t>(take_number(input, 255));
    shards.push_back({index, take(input, take_number(input, 300))});
  }
  rebuild(bodies, shards);
}

void rebuild_what_is_missing(Bodies bodies, size_t missing) {
  const auto parity = make_parity(bodies, missing);
  std::vector<ParityShard> shards;
  for (const auto& shard : parity) shards.push_back({static_cast<uint8_t>(shards.size()), shard});
  const Bodies all = bodies;
  for (size_t i = 0; i < missing; ++i) bodies[i] = {};
  const auto rebuilt = rebuild(bodies, shards);
  require(rebuilt.size() == missing, "enough shards rebuild everything");
  for (size_t i = 0; i < missing; ++i) {
    require(std::equal(rebuilt[i].begin(), rebuilt[i].end(), all[i].begin(), all[i].end()), "as it was");
  }
}

}  // namespace
}  // namespace gnomon::fuzz

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace gnomon::fuzz;
  using namespace gnomon::protocol;
  std::span<const uint8_t> input(data, size);
  const size_t slices = 1 + take_number(input, 12),
               missing = 1 + take_number(input, static_cast<uint32_t>(slices - 1));
  Bodies bodies;
  for (size_t i = 0; i < slices; ++i) {
    const auto body = take(input, 1 + take_number(input, 60));
    if (body.empty()) return 0;
    bodies.push_back(body);
  }
  rebuild_what_is_missing(bodies, missing);
  for (size_t i = 0; i < missing; ++i) bodies[i] = {};
  rebuild_from_anything(bodies, input);
  return 0;
}
