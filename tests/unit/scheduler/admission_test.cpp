#include "scheduler/admission_control.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

namespace gnomon::scheduler {
namespace {

using namespace std::chrono_literals;
constexpr TenantId kOne{0}, kTwo{1};

// 1 ns and 0.01 bytes a bit.
CostModel model() {
  CostModel made;
  made.learn({1'000'000, 8'000'000, true}, 8ms, 8ms);
  made.learn_bytes(8'000'000, 80'000);
  return made;
}

// Costs 8 ms and 80 kB: 125 a second are the whole device.
constexpr Demand kDemand{1000, 1000, 8, 30};

class AdmissionTest : public testing::Test {
 protected:
  void limit(const TenantLimits& one, double capacity = 1) {
    admission_.set_limits({.capacity = capacity}, {one, {}});
  }

  AdmissionRejection refused(const Demand& demand, TenantId tenant = kOne) {
    const auto verdict = admission_.book(tenant, demand, model_);
    EXPECT_TRUE(std::holds_alternative<AdmissionRejection>(verdict));
    return std::holds_alternative<AdmissionRejection>(verdict) ? std::get<AdmissionRejection>(verdict)
                                                               : AdmissionRejection{};
  }
  bool admitted(const Demand& demand, TenantId tenant = kOne) {
    return std::holds_alternative<Booking>(admission_.book(tenant, demand, model_));
  }

  CostModel model_ = model();
  AdmissionControl admission_;
};

TEST_F(AdmissionTest, CapacityIsSharedByAllAndAnOfferFits) {
  limit({});
  for (int i = 0; i < 4; ++i) EXPECT_TRUE(admitted(kDemand, i % 2 ? kOne : kTwo)) << i;
  const AdmissionRejection rejection = refused(kDemand);  // 0.96 are taken
  EXPECT_EQ(rejection.limit, Limit::capacity);
  EXPECT_EQ(rejection.fit_rate_hz, 5);
  Demand smaller = kDemand;
  smaller.width = rejection.fit_width;
  smaller.height = rejection.fit_height;
  EXPECT_TRUE(admitted(smaller));
}

TEST_F(AdmissionTest, ARateWithoutMeasureIsRefusedAtOnceAndOfferedWhatFits) {
  limit({.buffers_per_second = 45});
  for (const double rate : {46.0, 1e5, 1e9, double{std::numeric_limits<float>::max()}}) {
    EXPECT_EQ(refused({1000, 1000, 8, rate}).fit_rate_hz, 45) << rate;
  }
  limit({.width = 10, .height = 10});
  EXPECT_EQ(refused({1000, 1000, 8, std::numeric_limits<float>::max()}).fit_rate_hz, 0) << "no rate would help";
}

TEST_F(AdmissionTest, AreaLightsBookTheirWeightAndTheMemoryOfTheirPlanes) {
  const Demand soft{1000, 1000, 8, 30, false, 4, 16};  // as 14 lights; of 8 + 4 * 4 planes
  limit({.bits_per_second = 30 * 14e6});
  EXPECT_TRUE(admitted(soft));
  EXPECT_EQ(refused(soft).limit, Limit::bits);
  AdmissionControl memory;
  memory.set_limits({}, {{}, {}});
  const auto booked = std::get<Booking>(memory.book(kOne, soft, model_));
  const auto hard = std::get<Booking>(memory.book(kOne, kDemand, model_));
  EXPECT_EQ(booked.memory_bytes - hard.memory_bytes, 2 * 16 * 1'000'000 / 8);
  EXPECT_GT(booked.host_bytes, hard.host_bytes);
  EXPECT_NEAR(booked.load / hard.load, 14.0 / 8, 1e-9);
}

TEST_F(AdmissionTest, WhoAsksForNoRateGetsWhatIsLeft) {
  limit({.buffers_per_second = 1}, 0.001);
  for (int i = 0; i < 100; ++i) EXPECT_TRUE(admitted({4000, 2000, 8, 0}));
}

TEST_F(AdmissionTest, EveryLimitOfATenantIsKeptAndNamed) {
  const std::vector<std::pair<TenantLimits, Limit>> cases{
      {{.buffers_per_second = 45}, Limit::buffers},     {{.bits_per_second = 30 * 12e6}, Limit::bits},
      {{.bytes_per_second = 30 * 120e3}, Limit::bytes}, {{.gpu_share = 0.3}, Limit::gpu_share},
      {{.memory_bytes = 15'000'000}, Limit::memory},    {{.host_bytes = 15'000'000}, Limit::host_memory},
  };
  for (const auto& [limits, named] : cases) {
    admission_ = AdmissionControl();
    limit(limits);
    EXPECT_TRUE(admitted(kDemand)) << to_string(named);
    EXPECT_EQ(refused(kDemand).limit, named);
    EXPECT_TRUE(admitted(kDemand, kTwo)) << "another tenant has limits of its own";
  }
}

TEST_F(AdmissionTest, ASizeThatFitsIsOffered) {
  limit({.width = 640, .height = 480});
  const AdmissionRejection rejection = refused({1280, 720, 8, 30});
  EXPECT_EQ(rejection.limit, Limit::size);
  EXPECT_EQ(rejection.fit_width, 640u);
  EXPECT_EQ(rejection.fit_height, 360u);
  EXPECT_EQ(rejection.fit_rate_hz, 0) << "no rate would help";
}

TEST_F(AdmissionTest, WhatIsReleasedCanBeBookedAgain) {
  limit({.buffers_per_second = 90,
         .bits_per_second = 30 * 24e6,
         .bytes_per_second = 30 * 240e3,
         .gpu_share = 0.72,
         .memory_bytes = 40'000'000,
         .host_bytes = 30'000'000});
  std::mt19937 random(4);
  std::vector<Booking> held;
  for (int i = 0; i < 100'000; ++i) {
    if (!held.empty() && random() % 2) {
      admission_.release(kOne, held.back());
      held.pop_back();
      continue;
    }
    const auto verdict = admission_.book(kOne, kDemand, model_);
    ASSERT_EQ(std::holds_alternative<Booking>(verdict), held.size() < 3) << i;
    if (const auto* booking = std::get_if<Booking>(&verdict)) held.push_back(*booking);
  }
  uint64_t host_bytes = 0;
  for (const Booking& booking : held) host_bytes += booking.host_bytes;
  EXPECT_EQ(admission_.host_bytes(kOne), host_bytes);
  EXPECT_EQ(admission_.host_bytes(), host_bytes);
}

// A megabyte of masks: at most two frames being coded, four kept with parity and twelve references.
TEST_F(AdmissionTest, AHostMayHaveToKeepReferencesAndFramesToSendAgain) {
  limit({}, 0);
  Demand demand = kDemand;
  const auto plain = std::get<Booking>(admission_.book(kOne, demand, model_)).host_bytes;
  demand.references = true;
  const auto referring = std::get<Booking>(admission_.book(kOne, demand, model_)).host_bytes;
  EXPECT_GE(plain, 6'000'000u);
  EXPECT_GE(referring - plain, 12'000'000u);
}

TEST_F(AdmissionTest, MemoryThatIsReservedForATenantIsLeftToIt) {
  constexpr uint64_t kReserve = 20'000'000;
  admission_.set_limits({.host_bytes = 100'000'000},
                        {{.reserved_host_bytes = kReserve}, {.reserved_host_bytes = kReserve}});
  while (admitted(kDemand)) {
  }
  EXPECT_LE(admission_.host_bytes(kOne), 80'000'000u);
  EXPECT_GE(admission_.host_bytes(kOne), 70'000'000u);
  EXPECT_EQ(refused(kDemand).limit, Limit::host_memory);
  while (admitted(kDemand, kTwo)) {
  }
  EXPECT_GE(admission_.host_bytes(kTwo), 16'000'000u) << "within its reserve";
  EXPECT_LE(admission_.host_bytes(), 100'000'000u);
  const AdmissionRejection rejection = refused(kDemand, kTwo);
  EXPECT_EQ(rejection.limit, Limit::host_memory);
  EXPECT_GT(rejection.fit_width, 0u) << "a smaller size fits";
  Demand smaller = kDemand;
  smaller.width = rejection.fit_width;
  smaller.height = rejection.fit_height;
  EXPECT_TRUE(admitted(smaller, kTwo));
}

TEST_F(AdmissionTest, WithoutMeasurementsTheDeviceIsNotThoughtFull) {
  limit({}, 0.01);
  EXPECT_TRUE(std::holds_alternative<Booking>(admission_.book(kOne, kDemand, CostModel())));
}

}  // namespace
}  // namespace gnomon::scheduler
