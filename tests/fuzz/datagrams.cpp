// One datagram, as either side takes it: the header test, every body's decoder, and the seal of a session whose keys the
// input cannot know.
#include "protocol/datagram.h"
#include "protocol/feedback.h"
#include "protocol/parity.h"
#include "protocol/seal.h"
#include "tests/fuzz/target.h"

namespace gnomon::fuzz {
namespace {

using namespace protocol;

void open(std::span<const uint8_t> datagram, const Header& header) {
  SealSecrets secrets;
  secrets.client.fill(0x5a);
  secrets.server.fill(0xa5);
  for (const Side side : {Side::client, Side::server}) {
    Seal seal(header.session, CipherId::aes_128_gcm, secrets, side);
    require(!seal.open(datagram), "nobody guesses a tag");
  }
}

void decode_bodies(std::span<const uint8_t> body) {
  std::vector<uint8_t> again;
  if (const auto update = decode_camera_update(body)) {
    append_camera_update(again, *update);
    const auto twice = decode_camera_update(again);
    require(twice && *twice == *update, "a camera update comes back");
  }
  if (const auto slice = decode_frame_slice(body)) {
    require(slice->payload.size() <= body.size(), "a payload lies in its body");
  }
  if (const auto feedback = decode_feedback(body))
    require(feedback->count <= kMaxReported, "no more than there are");
  if (const auto parity = decode_parity(body)) {
    require(slices_of_group(parity->header) <= kMaxGroupSlices, "a group has its bounds");
  }
}

}  // namespace
}  // namespace gnomon::fuzz

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace gnomon::fuzz;
  const std::span<const uint8_t> datagram(data, size);
  if (const auto header = gnomon::protocol::decode_header(datagram)) open(datagram, *header);
  decode_bodies(datagram);
  return 0;
}
