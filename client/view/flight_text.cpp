#include "client/view/flight_text.h"

#include <cstdio>
#include <string>

namespace gnomon::client {

void print_figures(const FlightStats& f) {
  const auto ms = [&](double share) { return to_milliseconds(f.latencies.percentile(share)); };
  const auto age_ms = [&](double share) { return to_milliseconds(f.ages.percentile(share)); };
  // A newer camera was answered in their place: the server, or the link, did not manage the rate.
  const uint64_t unanswered = f.counters.unanswered + f.pending;
  const uint64_t coalesced = f.counters.asked - f.counters.complete - f.counters.incomplete - unanswered;
  std::printf("frames      %llu complete, %llu with tiles missing, %llu cameras coalesced, %llu unanswered\n",
              static_cast<unsigned long long>(f.counters.complete),
              static_cast<unsigned long long>(f.counters.incomplete), static_cast<unsigned long long>(coalesced),
              static_cast<unsigned long long>(unanswered));
  std::printf("response    min %.1f  p50 %.1f  p99 %.1f  max %.1f ms\n", ms(0), ms(0.5), ms(0.99), ms(1));
  std::printf("shown       %llu pictures, %.2f a second, p50 %.1f  p99 %.1f ms after their cameras, x %.1f\n",
              static_cast<unsigned long long>(f.shown), f.fps(), age_ms(0.5), age_ms(0.99), f.mean_ahead());
  std::printf("rate        %.2f visibility buffers a second; drawing took %.1f ms a picture\n", f.vbps(),
              f.shown ? 1000 * f.draw_seconds / static_cast<double>(f.shown) : 0.0);
  std::printf("network     %.0f bytes a frame, %llu slices lost, %llu invalid\n", f.bytes_per_frame(),
              static_cast<unsigned long long>(f.counters.lost_slices),
              static_cast<unsigned long long>(f.counters.invalid_slices));
}

void print_granted(SampleCounts wanted, SampleCounts granted) {
  if (wanted.per_light > 1) std::printf("samples     %d granted of each area light\n", int{granted.per_light});
  if (wanted.occlusion != Occlusion::none)
    std::printf("occlusion   %s granted\n", std::string(to_string(granted.occlusion)).c_str());
}

}  // namespace gnomon::client
