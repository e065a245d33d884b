// The client of a server that shades: sends cameras along a path, decodes and keeps what comes.
#pragma once

#include "client/cli/latency.h"
#include "client/media/camera_path.h"
#include "client/net/data_channel.h"
#include "client/net/loop.h"
#include "tests/eval/remote/screen.h"

namespace gnomon::remote {

struct FlightPlan {
  client::Address server;
  protocol::SealSecrets secrets;
  client::ViewSize size;
  uint32_t frames = 120;
  double rate_hz = 30, from_s = 0;  // from that second of the path on, at its own speed
};

struct FlightResult {
  Screen screen;
  client::Latencies response;  // from the camera's sending to the decoded picture
  client::Latencies decode;
  uint64_t received_bytes = 0;  // whole datagrams
  uint32_t not_decoded = 0;
  double seconds = 0;  // from the first camera to the last picture
};

// Blocks until every camera was sent and what was under way has come. Error: no socket, no decoder.
Result<FlightResult> fly(const client::CameraPath& path, const FlightPlan& plan);

}  // namespace gnomon::remote
