// A client's WebSocket, in pieces of any size. What is read does not depend on the pieces, and no message is longer than
// it may be.
#include "daemon/web/message_stream.h"
#include "tests/fuzz/target.h"

namespace {

using namespace gnomon::daemon::web;

constexpr size_t kMost = 1000;

struct Read {
  std::vector<FrameReader::Event> events;
  int violation = 0;
};

Read read_all(std::span<const uint8_t> input, size_t piece) {
  FrameReader reader(kMost);
  Read read;
  while (!input.empty()) {
    reader.feed(gnomon::fuzz::take(input, piece));
    while (true) {
      auto next = reader.next();
      if (const auto* violation = std::get_if<Violation>(&next)) {
        read.violation = static_cast<int>(violation->code);
        return read;
      }
      auto& event = std::get<std::optional<FrameReader::Event>>(next);
      if (!event) break;
      gnomon::fuzz::require(event->payload.size() <= kMost, "a message is no longer than it may be");
      read.events.push_back(std::move(*event));
      if (read.events.back().kind == FrameReader::Event::Kind::close) return read;
    }
  }
  return read;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace gnomon::fuzz;
  std::span<const uint8_t> input(data, size);
  const size_t piece = 1 + take_number(input, 4095);
  const Read whole = read_all(input, input.size() + 1), pieces = read_all(input, piece);
  require(whole.violation == pieces.violation && whole.events.size() == pieces.events.size(),
          "the same is read in pieces");
  for (size_t i = 0; i < whole.events.size(); ++i) {
    require(whole.events[i].payload == pieces.events[i].payload, "and its payload");
  }
  MessageStream messages(kMost);
  messages.become_websocket();
  messages.feed(input);
  while (true) {
    const auto message = messages.next();
    if (!message || !*message) break;
  }
  return 0;
}
