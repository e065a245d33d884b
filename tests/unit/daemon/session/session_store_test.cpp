// The session store: records that outlive a process, their use, and how the next process takes them over.
#include "daemon/session/session_store.h"

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>

#include "daemon/session/resumption.h"

namespace gnomon::daemon {
namespace {

using namespace std::chrono_literals;

constexpr size_t kMost = 3;
constexpr Nanoseconds kPatience = 1h;

std::unique_ptr<SessionStore> open(std::optional<int> left = {}, size_t most = kMost) {
  return SessionStore::open(most, kPatience, left).value();
}

SessionRecord record(uint64_t id) {
  SessionRecord record;
  record.id = id;
  record.resumption[0] = static_cast<uint8_t>(id);
  return record;
}

// A claim, and the record that it was answered with, if it was answered.
struct Claim {
  bool answered = false;
  StoredSession stored;
  SessionStore::Claimed done() {
    return [this](StoredSession claimed) {
      answered = true;
      stored = std::move(claimed);
    };
  }
};

TEST(SessionStore, RecordsAreUsedByOneAtATime) {
  const auto store = open();
  StoredSession first = store->add(record(7));
  ASSERT_TRUE(first);
  EXPECT_EQ(store->resting(), 0u);
  int wanted = 0;
  first.when_wanted([&] { ++wanted; });
  Claim second, third;
  store->claim(SessionId{7}, second.done());
  EXPECT_EQ(wanted, 1);
  EXPECT_FALSE(second.answered);
  store->claim(SessionId{7}, third.done());
  EXPECT_TRUE(second.answered) << "the newest claim wins";
  EXPECT_FALSE(second.stored);
  first = {};
  ASSERT_TRUE(third.stored);
  EXPECT_EQ(third.stored.record().id, 7u);
  third.stored = {};
  EXPECT_EQ(store->resting(), 1u);
}

TEST(SessionStore, WhoUsesItLaterHearsOfAClaimThatWaits) {
  const auto store = open();
  StoredSession stored = store->add(record(7));
  Claim claim;
  store->claim(SessionId{7}, claim.done());
  int wanted = 0;
  stored.when_wanted([&] { ++wanted; });
  EXPECT_EQ(wanted, 1);
  stored.forget();
  EXPECT_TRUE(claim.answered);
  EXPECT_FALSE(claim.stored);
}

TEST(SessionStore, HasRoomForSoMany) {
  const auto store = open();
  std::vector<StoredSession> all;
  for (uint64_t id = 1; id <= kMost; ++id) ASSERT_TRUE(all.emplace_back(store->add(record(id))));
  EXPECT_FALSE(store->add(record(9)));
  all.back().forget();
  StoredSession another = store->add(record(9));
  EXPECT_TRUE(another);
  EXPECT_FALSE(store->add(record(1))) << "twice the same";
}

TEST(SessionStore, WhatHasRestedForTooLongIsWiped) {
  const auto store = open();
  store->add(record(7));  // its StoredSession is dropped at once
  EXPECT_EQ(store->resting(), 1u);
  store->expire(Clock::now());
  EXPECT_EQ(store->resting(), 1u);
  EXPECT_TRUE(store->resumption_secret(SessionId{7}));
  store->expire(Clock::now() + kPatience);
  EXPECT_EQ(store->resting(), 0u);
  EXPECT_FALSE(store->resumption_secret(SessionId{7}));
}

// A process is killed while it changes records, at many different moments, so that most of its steps are interrupted.
TEST(SessionStore, TheNextLifeFindsWholeRecordsWheneverTheLastOneWasKilled) {
  size_t found = 0;
  for (int round = 0; round < 60; ++round) {
    auto before = open();
    const int left = dup(before->descriptor());
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      for (uint64_t id = 1;; ++id) {
        StoredSession stored = before->add(record(id));
        if (!stored) {  // full of those that rest
          before->forget_resting();
          continue;
        }
        protocol::EpochSecret& epoch = stored.record().seal.sending;
        for (uint8_t i = 1; i < 5; ++i) {
          protocol::Secret next;
          next.fill(static_cast<uint8_t>(epoch.epoch + 1));
          epoch.go_on(next);
        }
        if (id % 2) stored.forget();
        if (!before->add(record(id + (1ull << 32)))) before->forget_resting();
      }
    }
    usleep(static_cast<useconds_t>(400 * round));
    kill(child, SIGKILL);
    ASSERT_EQ(waitpid(child, nullptr, 0), child);
    before.reset();
    const auto after = open(left);
    ASSERT_TRUE(after->taken_over());
    found += after->resting();
    for (uint64_t id = 1; after->resting() > 0; ++id) {
      for (const uint64_t candidate : {id, id + (uint64_t{1} << 32)}) {
        Claim claim;
        if (!after->resumption_secret(SessionId{candidate})) continue;
        after->claim(SessionId{candidate}, claim.done());
        ASSERT_TRUE(claim.stored);
        const SessionRecord& stored = claim.stored.record();
        EXPECT_EQ(stored.resumption[0], static_cast<uint8_t>(candidate));
        const protocol::Secret& secret = stored.seal.sending.secret();
        for (const uint8_t byte : secret) ASSERT_EQ(byte, stored.seal.sending.epoch) << "half a secret";
        claim.stored.forget();
      }
      ASSERT_LT(id, 1ull << 31);
    }
  }
  EXPECT_GT(found, 10u);
}

TEST(SessionStore, AnotherShapeIsNotTakenOver) {
  int left = dup(open(std::nullopt, kMost + 1)->descriptor());
  EXPECT_FALSE(open(left)->taken_over());
  left = memfd_create("other", 0);
  EXPECT_FALSE(open(left)->taken_over());
  int pipes[2];
  ASSERT_EQ(pipe(pipes), 0);
  EXPECT_FALSE(open(pipes[0])->taken_over());
  close(pipes[1]);
}

TEST(SessionStore, WhatMakesNoSenseIsRefused) {
  Config config;
  config.tenants = {TenantConfig{}};
  config.tenants[0].name = "studio";
  const TenantDirectory directory = TenantDirectory().with(config.tenants);
  const FindScene find = [](const std::string& asked) { return asked == "room" ? asked : std::string(); };
  const SessionGrant grant{
      .scene_name = "room",
      .width = 64,
      .height = 64,
      .codec = protocol::CodecId::raw32_lz4,
      .dense_codec = protocol::CodecId::tiles_context,
      .cipher = protocol::CipherId::chacha20_poly1305,
      .features = protocol::kFeatureResume | protocol::kFeatureFeedback | protocol::kFeaturePaths};
  const SessionRecord good = record_of(SessionId{7}, grant, "studio", {});
  const auto again = grant_of(good, directory, config, find);
  const auto* same = std::get_if<SessionGrant>(&again);
  ASSERT_TRUE(same);
  EXPECT_EQ(same->scene_name, grant.scene_name);
  EXPECT_EQ(same->width, grant.width);
  EXPECT_EQ(same->codec, grant.codec);
  EXPECT_EQ(same->dense_codec, grant.dense_codec);
  EXPECT_EQ(same->cipher, grant.cipher);
  EXPECT_EQ(same->features, grant.features);
  const auto refuses = [&](auto change) {
    SessionRecord bad = good;
    change(bad);
    return std::holds_alternative<protocol::Refused>(grant_of(bad, directory, config, find));
  };
  EXPECT_TRUE(refuses([](SessionRecord& r) { r.tenant[0] = 'x'; }));
  EXPECT_TRUE(refuses([](SessionRecord& r) { r.scene[0] = 'x'; }));
  EXPECT_TRUE(refuses([](SessionRecord& r) { r.width = 65535; }));
  EXPECT_TRUE(refuses([](SessionRecord& r) { r.height = 0; }));
  EXPECT_TRUE(refuses([](SessionRecord& r) { r.codec = protocol::CodecId{77}; }));
  EXPECT_TRUE(refuses([](SessionRecord& r) { r.cipher = protocol::CipherId{0}; }));
  EXPECT_TRUE(refuses([](SessionRecord& r) { r.rate_hz = -1; }));
}

}  // namespace
}  // namespace gnomon::daemon
