// In the place of the other sources here where ngtcp2 and nghttp3 were missing at build.
#include "daemon/quic/endpoint.h"

namespace gnomon::daemon::quic {

bool is_built_in() { return false; }

Result<std::unique_ptr<Endpoint>> make_endpoint(const Options&) {
  return Error{"this gnomond was built without WebTransport"};
}

}  // namespace gnomon::daemon::quic
