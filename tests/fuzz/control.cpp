// A byte stream of control messages, in pieces of any size. What decodes must come back from its own encoding.
#include "protocol/messages.h"
#include "tests/fuzz/target.h"

namespace gnomon::fuzz {
namespace {

using protocol::Message;
using protocol::MessageReader;

void check_round_trip(const Message& message) {
  const std::vector<uint8_t> bytes = protocol::encode(message);
  MessageReader reader;
  reader.feed(bytes);
  const auto again = reader.next();
  require(again && *again, "an encoded message decodes");
  require(protocol::encode(**again) == bytes, "and encodes to the same bytes");
}

}  // namespace
}  // namespace gnomon::fuzz

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace gnomon::fuzz;
  std::span<const uint8_t> input(data, size);
  const size_t piece = 1 + take_number(input, 4095);
  gnomon::protocol::MessageReader reader;
  while (!input.empty()) {
    reader.feed(take(input, piece));
    while (true) {
      const auto message = reader.next();
      if (!message) return 0;
      if (!*message) break;
      check_round_trip(**message);
    }
  }
  return 0;
}
