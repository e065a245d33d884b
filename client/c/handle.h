// The opaque types of gnomon.h, and the boundary of the library: every entry point that may throw goes through
// guarded(), which lets no exception out.
#pragma once

#include <gnomon/gnomon.h>

#include <array>
#include <cstdio>
#include <exception>
#include <memory>
#include <new>
#include <string>
#include <utility>
#include <vector>

#include "client/c/engine_session.h"

struct gnomon_client {
  std::unique_ptr<gnomon::client::c::EngineSession> session;  // null if it could not be opened
  gnomon_result broken = GNOMON_OK;                           // an error after which every call fails
  std::array<char, 1024> error{};  // an array, which can be written when memory is exhausted
};

struct gnomon_mask {
  std::shared_ptr<const gnomon::client::ReceivedMasks> received;
  std::vector<uint32_t> missing_tiles;
};

namespace gnomon::client::c {

// How a call ends: a result and, if that is an error, a sentence about it.
struct Outcome {
  gnomon_result result = GNOMON_OK;
  std::string why = {};
};

inline Outcome bad_argument(std::string why) { return {GNOMON_BAD_ARGUMENT, std::move(why)}; }
inline Outcome wrong_size(const char* what) {
  return bad_argument(std::string(what) + " is NULL, or its size is not sizeof " + what);
}

inline gnomon_result remember(gnomon_client& client, gnomon_result result, const char* why) noexcept {
  if (result < 0) std::snprintf(client.error.data(), client.error.size(), "%s", why);
  return result;
}

// A client in which an exception was thrown is in an unknown state: it serves no further call.
inline gnomon_result give_up(gnomon_client& client, gnomon_result result, const char* why) noexcept {
  client.broken = result;
  return remember(client, result, why);
}

// Calls `body`, which takes the client and returns an Outcome, and turns exceptions into results.
template <class Body>
gnomon_result guarded(gnomon_client* client, Body&& body) noexcept {
  if (!client) return GNOMON_BAD_ARGUMENT;
  if (client->broken != GNOMON_OK) return client->broken;
  try {
    const Outcome outcome = body(*client);
    return remember(*client, outcome.result, outcome.why.c_str());
  } catch (const std::bad_alloc&) {
    return give_up(*client, GNOMON_NO_MEMORY, "there is not enough memory");
  } catch (const std::exception& error) {
    return give_up(*client, GNOMON_INTERNAL, error.what());
  } catch (...) {
    return give_up(*client, GNOMON_INTERNAL, "something was thrown that is no std::exception");
  }
}

}  // namespace gnomon::client::c
