// A client of libgnomon, as an engine uses it, and the options with which it connects to a scripted server.
#pragma once

#include <gnomon/gnomon.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/unit/client/net/fake_server.h"

namespace gnomon::tests::c {

inline constexpr uint16_t kWidth = 156, kHeight = 90, kBorder = 4;  // the last tiles lie in part beyond the picture
inline constexpr TileGrid kGrid{kWidth + kBorder, kHeight + kBorder, 2};
inline constexpr uint32_t kPatienceMs = 10'000;

// Options, and the texts to which they point.
struct Wanted {
  std::string server, pin = FakeServer::trust().pin;
  gnomon_options options{};

  explicit Wanted(const client::Address& address) : server(client::to_string(address)) {
    options.size = sizeof options;
    options.server = server.c_str();
    options.pin = pin.c_str();
    options.scene = "little";
    options.width = kWidth;
    options.height = kHeight;
    options.border_x = options.border_y = kBorder;
  }
};

// An open or failed client, freed at the end.
struct Client {
  gnomon_client* handle = nullptr;
  gnomon_result opened;

  explicit Client(const gnomon_options* options) : opened(gnomon_open(options, &handle)) {}
  explicit Client(const Wanted& wanted) : Client(&wanted.options) {}
  Client(const Client&) = delete;
  ~Client() { gnomon_free(handle); }

  gnomon_result wait(uint32_t ms = kPatienceMs) { return gnomon_wait_open(handle, ms); }
  std::string error() const { return gnomon_last_error(handle); }
  gnomon_state state() {
    gnomon_session session{};
    session.size = sizeof session;
    EXPECT_EQ(gnomon_get_session(handle, &session), GNOMON_OK);
    return session.state;
  }
};

inline gnomon_camera camera_at(float x) {
  gnomon_camera camera{};
  camera.position[0] = x;
  camera.orientation[3] = 1;
  EXPECT_EQ(gnomon_camera_perspective(&camera, 1.0f, kWidth, kHeight, kBorder, kBorder), GNOMON_OK);
  camera.near_plane = 0.1f;
  return camera;
}

inline protocol::Welcome welcome() { return small_welcome(kGrid.width, kGrid.height, kGrid.planes); }

// Sends a Welcome, and waits until the client ends.
inline void host(Peer& peer) {
  peer.read();
  peer.welcome(welcome());
  peer.read();
}

}  // namespace gnomon::tests::c
