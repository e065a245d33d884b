#include "daemon/render/scene_costs.h"

namespace gnomon::daemon {
namespace {

constexpr double kSurprise = 1.25;

}  // namespace

bool SceneCosts::learn(const JobFinished& job) {
  scheduler::CostModel& model = (job.unbuilt ? unbuilt_ : built_)[job.scene];
  const double before = to_seconds(model.predict(job.work).total());
  model.learn(job.work, job.gpu, job.trace);
  const double after = to_seconds(model.predict(job.work).total());
  return before > kSurprise * after || after > kSurprise * before;
}

}  // namespace gnomon::daemon
