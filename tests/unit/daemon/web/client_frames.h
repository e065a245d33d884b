// WebSocket frames as clients send them, right or wrong.
#pragma once

#include "daemon/web/websocket.h"

namespace gnomon::daemon::web {

struct ClientFrame {
  bool final = true;
  bool masked = true;
  uint8_t reserved = 0;
};

inline std::vector<uint8_t> client_frame(Opcode opcode, const std::vector<uint8_t>& payload, ClientFrame how = {}) {
  std::vector<uint8_t> frame;
  append_frame(frame, opcode, payload);
  frame[0] = static_cast<uint8_t>((how.final ? frame[0] : frame[0] & 0x7f) | how.reserved);
  if (!how.masked) return frame;
  constexpr uint8_t kMask[] = {0x37, 0xfa, 0x21, 0x3d};
  frame[1] |= 0x80;
  const size_t header = frame.size() - payload.size();
  for (size_t i = 0; i < payload.size(); ++i) frame[header + i] ^= kMask[i % 4];
  frame.insert(frame.begin() + static_cast<ptrdiff_t>(header), std::begin(kMask), std::end(kMask));
  return frame;
}

}  // namespace gnomon::daemon::web
