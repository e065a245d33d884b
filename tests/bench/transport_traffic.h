// Common code of the transport cases that use sockets and seals.
#pragma once

#include <string>

#include "protocol/codec.h"
#include "protocol/seal.h"
#include "tests/bench/transport.h"

namespace gnomon::bench {

inline constexpr SessionId kBenchSession{0x1234567890abcdef};
inline constexpr protocol::SealSecrets kBenchSecrets{{1, 2, 3}, {4, 5, 6}};
inline constexpr protocol::CipherId kCiphers[] = {protocol::CipherId::aes_128_gcm,
                                                  protocol::CipherId::chacha20_poly1305};

const char* name_of(protocol::CipherId cipher);

// Processor time of the calling thread.
double cpu_seconds();

// A frame of 1920x1080 with 3 lights and much detail; its slices have the longest bodies that `body_bytes` allows.
Result<protocol::EncodedMask> busy_frame(size_t body_bytes);

// A row of a report: the throughput of one core that took `cpu_s` for `datagrams` of `bytes` together.
nlohmann::ordered_json traffic_row(const std::string& name, const char* cipher, size_t datagrams, size_t bytes,
                                   double cpu_s);

}  // namespace gnomon::bench
