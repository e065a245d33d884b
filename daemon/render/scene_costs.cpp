#include "daemon/render/scene_costs.h"

namespace gnomon::daemon {
namespace {

constexpr double kSurprise = 1.25;

}  // namespace

bool SceneCosts::learn(const JobFinished& job) {
  scheduler::SampleCosts& costs = (job.unbuilt ? unbuilt_ : built_)[job.scene];
  const double before = to_seconds(costs.model(job.samples).predict(job.work).total());
  costs.of(job.samples).learn(job.work, job.gpu, job.trace);
  const double after = to_seconds(costs.model(job.samples).predict(job.work).total());
  return before > kSurprise * after || after > kSurprise * before;
}

}  // namespace gnomon::daemon
