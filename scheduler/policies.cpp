#include "scheduler/scheduler.h"

namespace gnomon::scheduler {

std::unique_ptr<Scheduler> make_scheduler(std::string_view policy, double priority_floor) {
  if (policy == "fair") return make_fair();
  if (policy == "priority") return make_priority(priority_floor);
  if (policy == "deadline") return make_deadline();
  if (policy == "round_robin") return make_round_robin();
  return nullptr;
}

}  // namespace gnomon::scheduler
