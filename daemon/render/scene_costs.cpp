#include "daemon/render/scene_costs.h"

#include "daemon/render/render_session.h"

namespace gnomon::daemon {
namespace {

constexpr double kSurprise = 1.25;

}  // namespace

bool SceneCosts::learn(const JobFinished& job, Nanoseconds quantum) {
  scheduler::SampleCosts& costs = (job.unbuilt ? unbuilt_ : built_)[job.scene];
  const auto predicted = [&] { return to_seconds(costs.model(job.samples).predict(job.work).total()); };
  const auto most_bits = [&] {
    return static_cast<double>(costs.bits_within(job.samples, quantum, most_soft_bits_));
  };
  const double before = predicted(), most_before = most_bits();
  costs.of(job.samples).learn(job.work, job.gpu, job.trace);
  if (quantum > Nanoseconds{}) {
    costs.of(job.samples).worst().learn(job.work.bits, job.trace, quantum / kJobsOfAQuantum);
  }
  const double after = predicted();
  return before > kSurprise * after || after > kSurprise * before || most_before > kSurprise * most_bits();
}

}  // namespace gnomon::daemon
