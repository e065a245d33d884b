// How much work is on a device: how many frames, and until when it is busy as far as predictions go. Pure.
#pragma once

#include <algorithm>
#include <cstdint>

#include "common/clock.h"

namespace gnomon::daemon {

class DeviceLoad {
 public:
  // A frame begins with its first submit, is partial until its last one, and is out until its lease has come back.
  void frame_begun() {
    ++frames_;
    ++partial_;
  }
  void frame_submitted() { --partial_; }
  void frame_abandoned() {
    --partial_;
    --frames_;
  }
  void lease_dropped() { --frames_; }

  void job_started(Nanoseconds predicted, TimePoint now) {
    ++jobs_;
    predicted_ += predicted;
    runs_dry_ = std::max(runs_dry_, now) + predicted;
  }
  void job_finished(Nanoseconds predicted, TimePoint now) {
    --jobs_;
    predicted_ -= predicted;
    runs_dry_ = now + predicted_;
  }

  // Of frames there are no more than the encoders can take. Of work on the device there is what keeps it busy: the next
  // job follows when, as far as predictions go, the device is about to run dry. Submitted earlier it would only stand
  // before a newcomer's; and where predictions fail, there are never more than two jobs of full length. `quantum` 0:
  // jobs are never cut, and the number of frames alone counts.
  bool has_room(uint32_t free_slots, uint32_t frames_in_flight, Nanoseconds quantum, TimePoint now) {
    room_at_ = TimePoint::max();
    if (free_slots == 0 || frames_ - partial_ >= frames_in_flight) return false;
    if (jobs_ == 0 || quantum <= Nanoseconds{}) return true;
    if (predicted_ > quantum / 2) return false;
    const TimePoint soon_dry = runs_dry_ - std::min(kLead, quantum / 4);
    if (soon_dry > now) room_at_ = soon_dry;
    return soon_dry <= now;
  }
  // When there is room if nothing happens before; max: something has to happen.
  TimePoint room_at() const { return room_at_; }

  uint32_t frames_out() const { return frames_; }
  bool idle() const { return frames_ == 0 && jobs_ == 0; }

 private:
  // Before the device runs dry: what waking up, recording and submitting take.
  static constexpr Nanoseconds kLead = std::chrono::milliseconds(1);

  uint32_t frames_ = 0;   // whose lease has not come back, partial ones included
  uint32_t partial_ = 0;  // of these, not all submitted
  uint32_t jobs_ = 0;     // submitted and not done
  Nanoseconds predicted_{};
  TimePoint runs_dry_{};  // when the jobs are done, as far as predictions go
  TimePoint room_at_ = TimePoint::max();
};

}  // namespace gnomon::daemon
