// Writes the seeds of the target `quic`: what a browser sends. The packets are new ones at each run, as QUIC's are.
//
//   fuzz_make_quic_seeds tests/fuzz/corpus/quic
#include <filesystem>
#include <fstream>

#include "daemon/quic/http3.h"
#include "daemon/quic/qpack.h"
#include "daemon/quic/varint.h"
#include "tests/unit/daemon/quic/quic_client.h"

namespace {

using namespace gnomon::daemon::quic;
using Bytes = std::vector<uint8_t>;

void put_number(Bytes& out, size_t value) {
  out.push_back(static_cast<uint8_t>(value >> 8));
  out.push_back(static_cast<uint8_t>(value));
}

void append(Bytes& out, const Bytes& more) { out.insert(out.end(), more.begin(), more.end()); }

// A step of the target: bytes of a stream.
Bytes step(uint8_t stream, const Bytes& bytes, bool ends = false) {
  Bytes out;
  put_number(out, stream);
  put_number(out, 2 * bytes.size() + (ends ? 1 : 0));
  append(out, bytes);
  return out;
}

Bytes frame(uint64_t type, const Bytes& body) {
  Bytes out;
  append_varint(out, type);
  append_varint(out, body.size());
  append(out, body);
  return out;
}

void write(const std::filesystem::path& file, const Bytes& bytes) {
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const std::filesystem::path folder = argv[1];
  std::filesystem::create_directories(folder);
  const Bytes request = frame(1, encode_fields(QuicClient::session_request("/session?ticket=0123456789abcdef")));
  Bytes session{0, 0};
  append(session, step(2, Http3::control_stream()));
  append(session, step(6, {2}));
  append(session, step(0, request));
  Bytes ended = session;
  append(ended, step(0, frame(0, {0x68, 0x43, 0}), true));
  Bytes others{0, 0};
  append(others, step(2, {0x40, 0x54, 0, 1, 2}));
  append(others, step(4, {0x40, 0x41, 0, 1, 2}));
  append(others, step(0, frame(0x21, Bytes(40))));
  append(others, step(0, request));
  write(folder / "session", session);
  write(folder / "ended", ended);
  write(folder / "others", others);
  QuicClient client(address_of("192.0.2.2", 4000), address_of("192.0.2.1", 7600), {},
                    gnomon::TimePoint(std::chrono::hours(1)));
  Bytes packets{0, 1};
  for (const Bytes& packet : client.take_packets(gnomon::TimePoint(std::chrono::hours(1)))) {
    put_number(packets, packet.size());
    put_number(packets, 0);
    append(packets, packet);
  }
  write(folder / "packets", packets);
  Bytes unknown = packets;
  unknown[6 + 4] = 0x77;  // another version
  write(folder / "version", unknown);
  return 0;
}
