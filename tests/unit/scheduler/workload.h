// Random traffic in virtual time, and an account of it that is independent of how a policy works.
//
// Tenants join, leave, idle, flood and change weight, views are withdrawn, jobs fail, the device is lost. The account
// checks, at every pick, what the header of the scheduler promises.
#pragma once

#include <cstdint>

#include "scheduler/scheduler.h"

namespace gnomon::scheduler {

struct Workload {
  uint64_t seed = 1;
  uint64_t picks = 100'000;
  uint32_t tenants = 6;
  uint32_t max_sessions = 12;  // of a tenant
  uint32_t in_flight = 3;      // jobs on the device at a time
  double max_cost_ns = 4e6;
  bool equal_weights = false;
  bool changes_weights = true;
  bool sessions_come_and_go = true;
  bool tenants_idle = true;
  bool withdraws = true;
  // Predictions are wrong by up to this share of the greatest cost; jobs fail and the device is lost.
  double error = 0;
};

struct Findings {
  uint64_t picks = 0;
  double worst_lag = 0;            // of two tenants, as a share of the promised bound
  double worst_wait = 0;           // of a session, as a share of what the bound leads to
  uint64_t idle_with_work = 0;     // picks of nothing while somebody waited
  uint64_t picks_without_job = 0;  // of a session that had asked for nothing
  uint64_t losses = 0;             // of the device
  double jain = 0;                 // of service by weight of the tenants that were always busy

  bool clean() const { return worst_lag <= 1 && worst_wait <= 1 && idle_with_work == 0 && picks_without_job == 0; }
};

Findings run(Scheduler& scheduler, const Workload& workload);

}  // namespace gnomon::scheduler
