// What became of the cameras of one or several clients, and where the time of their answers went.
#pragma once

#include <cstdint>

#include "client/cli/latency.h"
#include "client/stream/visibility_stream.h"

namespace gnomon::client {

// Sums over answers, by stage. The server states its own time and the device's with every slice, its queue's once a
// second (Stats), of which the share in those answers' waiting stands for all; what is left is that of encoding and sending
// there, and of the network and this program here.
struct StageTimes {
  uint64_t answers = 0;
  Nanoseconds response{};  // from the camera's sending to the last slice's arrival
  Nanoseconds server{};    // of it, from the camera's arrival at the server to the frame's sending
  Nanoseconds device{};    // of that, on the device
  Nanoseconds known{};     // of the server's time but the device's, that of answers whose queue is known
  Nanoseconds queue{};     // of that, from the camera's arrival to the start of rendering

  StageTimes& operator+=(const StageTimes& other);
  // Of the answers that have come since `before`, the queue took `mean` each.
  void take_queue(const StageTimes& before, Nanoseconds mean);

  // Means, in milliseconds; 0 if there was no answer.
  double response_ms() const { return mean_ms(response, answers); }
  double queue_ms() const;
  double device_ms() const { return mean_ms(device, answers); }
  double encode_ms() const;  // and sending; with the queue's where that is not known
  double network_ms() const { return mean_ms(response - server, answers); }
  bool knows_queue() const { return known > Nanoseconds(0); }

 private:
  static double mean_ms(Nanoseconds sum, uint64_t count);
};

struct LoadFigures {
  StreamCounters counters;      // from the end of the warm-up on; cameras that were under way then count
  uint64_t pending = 0;         // cameras without an answer when the run ended
  uint64_t frames_in_time = 0;  // complete, before the flight ended
  Latencies latencies;          // of these
  StageTimes times;
  uint64_t reopened = 0;      // sessions that were lost and replaced by another one
  Nanoseconds longest_gap{};  // the longest time that a client waited from one whole frame to the next
  uint64_t bytes = 0;         // of received datagrams, of the whole run

  LoadFigures& operator+=(const LoadFigures& other);

  uint64_t offered() const { return counters.asked; }
  uint64_t answered() const { return counters.complete + counters.incomplete; }
  // Without an answer: nothing came for them or for a newer one.
  uint64_t dropped() const { return counters.unanswered + pending; }
  // Without an answer, as a newer one was answered in their place.
  uint64_t coalesced() const;
  uint64_t without_answer() const { return coalesced() + dropped(); }
  double bytes_per_frame() const;
};

}  // namespace gnomon::client
