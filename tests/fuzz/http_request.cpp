// A browser's requests, in pieces of any size: what is read does not depend on the pieces, and is answered.
#include "daemon/web/static_files.h"
#include "daemon/web/upgrade.h"
#include "daemon/web/web_request.h"
#include "tests/fuzz/target.h"

namespace {

using namespace gnomon::daemon::web;

struct Read {
  std::vector<Request> requests;
  bool refused = false;
};

// A header that is none may be looked at when it has become longer: what is left at the end is followed by as much as a
// header may have.
Read read_all(std::span<const uint8_t> input, size_t piece) {
  static const std::vector<uint8_t> kNoHeader(RequestReader::kMaxHeader, 'x');
  RequestReader reader;
  Read read;
  for (bool ended = false; !ended;) {
    ended = input.empty();
    reader.feed(ended ? std::span(kNoHeader) : gnomon::fuzz::take(input, piece));
    while (true) {
      auto next = reader.next();
      read.refused = std::holds_alternative<BadRequest>(next);
      if (read.refused) return read;
      auto& request = std::get<std::optional<Request>>(next);
      if (!request) break;
      read.requests.push_back(std::move(*request));
    }
  }
  return read;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace gnomon::fuzz;
  static const StaticFiles files = StaticFiles::of(embedded_files());
  std::span<const uint8_t> input(data, size);
  const size_t piece = 1 + take_number(input, 4095);
  const Read whole = read_all(input, input.size() + 1), pieces = read_all(input, piece);
  require(whole.requests.size() == pieces.requests.size() && whole.refused == pieces.refused,
          "the same is read in pieces");
  for (size_t i = 0; i < whole.requests.size(); ++i) {
    require(
        whole.requests[i].target == pieces.requests[i].target && whole.requests[i].host == pieces.requests[i].host,
        "the same is read in pieces");
  }
  for (const Request& request : whole.requests) {
    require(!header_of(files.answer(request)).empty(), "a request is answered");
    require(upgrade(request).status != 101 || !request.origin.empty(), "nobody goes on without an origin");
  }
  return 0;
}
