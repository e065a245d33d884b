// How much work is on a device: the number of frames, and until when it is predicted to be busy. Pure.
#pragma once

#include <algorithm>
#include <cstdint>

#include "common/clock.h"

namespace gnomon::daemon {

class DeviceLoad {
 public:
  // A frame begins with its first submit, is partial until its last submit or until it is abandoned, and is out until its slot
  // is free.
  void frame_begun() {
    ++frames_;
    ++partial_;
  }
  void frame_submitted() { --partial_; }
  void frame_abandoned() { --partial_; }
  void slot_freed() { --frames_; }

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

  // Whether another job may be submitted. Submitted frames are limited to `frames_in_flight`, which the encoders can
  // take. Work on the device is limited to what keeps it busy: the next job is submitted shortly before the device is
  // predicted to run dry. Submitted earlier, it would only delay the job of a newcomer; and if predictions fail, there
  // are at most two jobs of full length on the device. A device that runs several jobs at the same time, `overlapping`,
  // is busy only with so many: it gets them at once, while what it has already takes no more than half a quantum.
  // `quantum` 0: jobs are never cut, and only frames are counted. Also sets room_at(), until which the caller then sleeps.
  bool look_for_room(uint32_t free_slots, uint32_t frames_in_flight, uint32_t overlapping, Nanoseconds quantum,
                     TimePoint now) {
    room_at_ = TimePoint::max();
    if (free_slots == 0 || frames_ - partial_ >= frames_in_flight) return false;
    if (jobs_ == 0 || quantum <= Nanoseconds{}) return true;
    if (predicted_ > quantum / 2) return false;
    if (jobs_ < overlapping) return true;
    const TimePoint soon_dry = runs_dry_ - std::min(kLead, quantum / 4);
    if (soon_dry > now) room_at_ = soon_dry;
    return soon_dry <= now;
  }
  // When there will be room if nothing happens before; TimePoint::max() if room depends on an event.
  TimePoint room_at() const { return room_at_; }

  uint32_t frames_out() const { return frames_; }
  bool idle() const { return frames_ == 0 && jobs_ == 0; }

 private:
  // How long before the device runs dry a job is submitted: the time to wake up, record and submit.
  static constexpr Nanoseconds kLead = std::chrono::milliseconds(1);

  uint32_t frames_ = 0;      // frames whose slot is not free, partial ones included
  uint32_t partial_ = 0;     // of these, frames that are not submitted completely
  uint32_t jobs_ = 0;        // submitted and not finished
  Nanoseconds predicted_{};  // cost of these jobs
  TimePoint runs_dry_{};     // when the jobs are predicted to be finished
  TimePoint room_at_ = TimePoint::max();
};

}  // namespace gnomon::daemon
