#include "tests/bench/transport_traffic.h"

#include <time.h>

#include "tests/unit/protocol/masks.h"

namespace gnomon::bench {

const char* name_of(protocol::CipherId cipher) {
  return cipher == protocol::CipherId::aes_128_gcm ? "aes_128_gcm" : "chacha20_poly1305";
}

double cpu_seconds() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

Result<protocol::EncodedMask> busy_frame(size_t body_bytes) {
  const tests::Mask mask = tests::foliage({1920, 1080, 3}, 1);
  protocol::EncodedMask frame;
  auto done = protocol::FrameEncoder().encode(mask.view(), protocol::CodecId::tiles_lz4,
                                              body_bytes - protocol::kSliceHeaderBytes, frame);
  if (!done) return done.error();
  return frame;
}

nlohmann::ordered_json traffic_row(const std::string& name, const char* cipher, size_t datagrams, size_t bytes,
                                   double cpu_s) {
  return {{"case", name},
          {"cipher", cipher},
          {"datagrams_per_s", static_cast<double>(datagrams) / cpu_s},  // of one core
          {"mbit_per_s", 8e-6 * static_cast<double>(bytes) / cpu_s}};
}

}  // namespace gnomon::bench
