#include "protocol/parity.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/unit/protocol/random_messages.h"

namespace gnomon::protocol {
namespace {

using Bytes = std::vector<uint8_t>;

std::vector<Bytes> random_bodies(tests::Random& random, size_t count, size_t longest) {
  std::vector<Bytes> bodies(count);
  for (Bytes& body : bodies) {
    body.resize(1 + random() % longest);
    for (uint8_t& byte : body) byte = static_cast<uint8_t>(random());
  }
  return bodies;
}

Bodies spans_of(const std::vector<Bytes>& bodies) { return {bodies.begin(), bodies.end()}; }

std::vector<ParityShard> shards_of(const std::vector<Bytes>& parity) {
  std::vector<ParityShard> shards;
  for (size_t i = 0; i < parity.size(); ++i) shards.push_back({static_cast<uint8_t>(i), parity[i]});
  return shards;
}

TEST(Parity, AnyLossesUpToItsCountAreRebuilt) {
  tests::Random random(1);
  for (int trial = 0; trial < 300; ++trial) {
    const size_t k = 1 + random() % (trial % 10 == 0 ? kMaxGroupSlices : 20), m = 1 + random() % 8;
    const auto bodies = random_bodies(random, k, 400);
    const auto parity = make_parity(spans_of(bodies), m);
    Bodies arrived = spans_of(bodies);
    auto shards = shards_of(parity);
    // Of the slices and parity shards together, m are lost.
    std::vector<size_t> order(k + m);
    for (size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::shuffle(order.begin(), order.end(), random);
    std::vector<size_t> missing;
    for (size_t i = 0; i < m; ++i) {
      if (order[i] < k) missing.push_back(order[i]);
    }
    std::erase_if(shards, [&](const ParityShard& shard) {
      return std::find(order.begin(), order.begin() + m, k + shard.index) != order.begin() + m;
    });
    std::sort(missing.begin(), missing.end());
    for (const size_t i : missing) arrived[i] = {};
    const auto found = rebuild(arrived, shards);
    ASSERT_EQ(found.size(), missing.size());
    for (size_t i = 0; i < missing.size(); ++i) EXPECT_EQ(found[i], bodies[missing[i]]);
  }
}

TEST(Parity, TooFewShardsRebuildNothing) {
  tests::Random random(2);
  const auto bodies = random_bodies(random, 8, 100);
  const auto parity = make_parity(spans_of(bodies), 2);
  Bodies arrived = spans_of(bodies);
  arrived[0] = arrived[3] = arrived[5] = {};
  EXPECT_TRUE(rebuild(arrived, shards_of(parity)).empty());
}

// Any parity shards give either all missing bodies or none.
TEST(Parity, NonsenseIsSurvived) {
  tests::Random random(3);
  for (int trial = 0; trial < 2000; ++trial) {
    const auto bodies = random_bodies(random, 1 + random() % 6, 60);
    auto parity = random_bodies(random, 1 + random() % 4, 80);
    Bodies arrived = spans_of(bodies);
    for (auto& body : arrived) {
      if (random() % 2) body = {};
    }
    auto shards = shards_of(parity);
    for (auto& shard : shards) shard.index = static_cast<uint8_t>(random());
    const auto found = rebuild(arrived, shards);
    const auto missing = std::count_if(arrived.begin(), arrived.end(), [](const auto& b) { return b.empty(); });
    EXPECT_TRUE(found.empty() || found.size() == static_cast<size_t>(missing));
  }
}

TEST(Parity, HeadersComeBackAndWrongOnesDoNot) {
  const ParityHeader header{FrameId{7}, 100, 4, 3, 2, 0};
  Bytes bytes;
  append_parity(bytes, header, Bytes(40, 1));
  ASSERT_EQ(bytes.size(), kParityHeaderBytes + 40);
  const auto got = decode_parity(bytes);
  ASSERT_TRUE(got);
  EXPECT_EQ(got->header, header);
  EXPECT_EQ(got->shard.size(), 40u);
  EXPECT_EQ(slices_of_group(header), 25u);
  const auto refused = [](const ParityHeader& wrong) {
    Bytes other;
    append_parity(other, wrong, Bytes(40, 1));
    return !decode_parity(other);
  };
  EXPECT_TRUE(refused({FrameId{7}, 100, 0, 0, 0, 0})) << "no groups";
  EXPECT_TRUE(refused({FrameId{7}, 100, 4, 4, 0, 0})) << "beyond the groups";
  EXPECT_TRUE(refused({FrameId{7}, 3, 4, 3, 0, 0})) << "the first group without slices";
  EXPECT_TRUE(refused({FrameId{7}, 2, 4, 3, 0, 0})) << "a group without slices";
  EXPECT_FALSE(refused({FrameId{7}, kMaxGroupSlices, 1, 0, 0, 0})) << "one group, the largest";
  EXPECT_TRUE(refused({FrameId{7}, kMaxGroupSlices + 1, 1, 0, 0, 0})) << "a group too large";
  EXPECT_FALSE(refused({FrameId{7}, 100, 4, 0, kMaxGroupParity - 1, 0})) << "the last index";
  EXPECT_TRUE(refused({FrameId{7}, 100, 4, 0, kMaxGroupParity, 0})) << "an index too large";
  EXPECT_FALSE(decode_parity(std::span(bytes).first(kParityHeaderBytes + 2)));
}

}  // namespace
}  // namespace gnomon::protocol
