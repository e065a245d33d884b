// Errors of libgnomon: each is a result and a sentence, and nothing is thrown.
#include <sys/resource.h>

#include <cstring>
#include <limits>

#include "tests/unit/client/c/c_client.h"

namespace gnomon::tests::c {
namespace {

using namespace std::chrono_literals;

inline bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(CErrors, AnotherCertificateThanThePinnedOne) {
  FakeServer server([](Peer& peer) { peer.read(); });
  Wanted wanted(server.address());
  wanted.pin = "sha256:" + std::string(64, '0');
  wanted.options.pin = wanted.pin.c_str();
  Client client(wanted);
  EXPECT_EQ(client.opened, GNOMON_OK) << "it has only begun";
  EXPECT_EQ(client.wait(), GNOMON_FAILED);
  EXPECT_TRUE(contains(client.error(), "certificate")) << client.error();
  EXPECT_EQ(client.state(), GNOMON_ENDED);
  gnomon_mask* mask = nullptr;
  EXPECT_EQ(gnomon_poll(client.handle, 0, &mask), GNOMON_FAILED) << "and it remains so";
}

TEST(CErrors, AnUnknownSceneIsARefusal) {
  FakeServer server([](Peer& peer) {
    peer.read();
    peer.write(protocol::Refused{protocol::RefusalCode::unknown_scene, "there is no such scene", 640, 360, 30});
  });
  Client client{Wanted(server.address())};
  EXPECT_EQ(client.wait(), GNOMON_REFUSED);
  EXPECT_TRUE(contains(client.error(), "there is no such scene")) << client.error();
  gnomon_refusal refusal{};
  refusal.size = sizeof refusal;
  ASSERT_EQ(gnomon_get_refusal(client.handle, &refusal), GNOMON_OK);
  EXPECT_EQ(refusal.code, 5u);
  EXPECT_EQ(refusal.fit_width, 640u);
  EXPECT_EQ(refusal.fit_height, 360u);
  EXPECT_EQ(refusal.fit_rate_hz, 30);
}

TEST(CErrors, NobodyThere) {
  Wanted wanted({"127.0.0.1", 1});
  Client client(wanted);
  EXPECT_EQ(client.wait(), GNOMON_FAILED);
  EXPECT_TRUE(contains(client.error(), "127.0.0.1:1")) << client.error();
}

TEST(CErrors, AServerThatEndsTheSession) {
  FakeServer server([](Peer& peer) {
    peer.read();
    peer.welcome(welcome());
    peer.write(protocol::Bye{"closing time"});
  });
  Wanted wanted(server.address());
  wanted.options.flags = GNOMON_STAY_LOST;
  Client client(wanted);
  client.wait();
  gnomon_mask* mask = nullptr;
  EXPECT_EQ(gnomon_poll(client.handle, kPatienceMs, &mask), GNOMON_FAILED) << "long before the patience ends";
  EXPECT_TRUE(contains(client.error(), "closing time")) << client.error();
}

// ---- arguments

TEST(CErrors, NullIsAnErrorAndNoCrash) {
  FakeServer server(host);
  Wanted wanted(server.address());
  EXPECT_EQ(gnomon_open(&wanted.options, nullptr), GNOMON_BAD_ARGUMENT);
  Client none(nullptr);
  EXPECT_EQ(none.opened, GNOMON_BAD_ARGUMENT);
  EXPECT_TRUE(contains(none.error(), "gnomon_options is NULL")) << none.error();
  Client client(wanted);
  ASSERT_EQ(client.wait(), GNOMON_OK) << client.error();
  const gnomon_camera camera = camera_at(0);
  for (gnomon_client* handle : {static_cast<gnomon_client*>(nullptr), none.handle, client.handle}) {
    gnomon_mask* mask = nullptr;
    EXPECT_EQ(gnomon_look(handle, nullptr, nullptr), GNOMON_BAD_ARGUMENT);
    EXPECT_EQ(gnomon_poll(handle, 0, nullptr), GNOMON_BAD_ARGUMENT);
    EXPECT_EQ(gnomon_get_scene(handle, nullptr), GNOMON_BAD_ARGUMENT);
    EXPECT_EQ(gnomon_get_session(handle, nullptr), GNOMON_BAD_ARGUMENT);
    EXPECT_EQ(gnomon_get_refusal(handle, nullptr), GNOMON_BAD_ARGUMENT);
    EXPECT_EQ(gnomon_get_statistics(handle, nullptr), GNOMON_BAD_ARGUMENT);
    EXPECT_EQ(gnomon_get_light(handle, 0, nullptr), GNOMON_BAD_ARGUMENT);
    EXPECT_EQ(gnomon_get_motion(handle, 0, nullptr), GNOMON_BAD_ARGUMENT);
    if (handle == client.handle) continue;
    EXPECT_EQ(gnomon_wait_open(handle, 0), GNOMON_BAD_ARGUMENT);
    EXPECT_EQ(gnomon_look(handle, &camera, nullptr), GNOMON_BAD_ARGUMENT);
    EXPECT_EQ(gnomon_poll(handle, 0, &mask), GNOMON_BAD_ARGUMENT);
    EXPECT_EQ(gnomon_close(handle, ""), GNOMON_BAD_ARGUMENT);
  }
  EXPECT_TRUE(contains(client.error(), "motions")) << client.error();
  EXPECT_NE(gnomon_last_error(nullptr), nullptr);
  gnomon_mask_view view{};
  view.size = sizeof view;
  EXPECT_EQ(gnomon_mask_get_view(nullptr, &view), GNOMON_BAD_ARGUMENT);
  EXPECT_EQ(gnomon_mask_lit(nullptr, 0, 0, 0), -1);
  EXPECT_EQ(gnomon_mask_has_tile(nullptr, 0, 0, 0), -1);
  EXPECT_EQ(gnomon_camera_perspective(nullptr, 1, 1, 1, 0, 0), GNOMON_BAD_ARGUMENT);
  gnomon_mask_free(nullptr);
  gnomon_free(nullptr);
}

TEST(CErrors, OptionsThatCannotBeMeantNameTheMember) {
  const auto error_of = [](auto change) {
    Wanted wanted({"127.0.0.1", 1});
    change(wanted.options);
    Client client(wanted);
    EXPECT_EQ(client.opened, GNOMON_BAD_ARGUMENT);
    EXPECT_EQ(client.wait(), GNOMON_BAD_ARGUMENT);
    return client.error();
  };
  using Options = gnomon_options;
  EXPECT_TRUE(error_of([](Options& o) { o.server = nullptr; }).starts_with("server"));
  EXPECT_TRUE(error_of([](Options& o) { o.server = "nowhere"; }).starts_with("server"));
  EXPECT_TRUE(error_of([](Options& o) { o.scene = nullptr; }).starts_with("scene"));
  EXPECT_TRUE(error_of([](Options& o) { o.width = 0; }).starts_with("width"));
  EXPECT_TRUE(error_of([](Options& o) { o.height = protocol::kMaxSide; }).starts_with("height"));
  EXPECT_TRUE(error_of([](Options& o) { o.border_x = ~0u; }).starts_with("width"));
  EXPECT_TRUE(error_of([](Options& o) { o.rate_hz = -1; }).starts_with("rate_hz"));
  EXPECT_TRUE(error_of([](Options& o) { o.codec = "mpeg"; }).starts_with("no codec 'mpeg'"));
  EXPECT_TRUE(error_of([](Options& o) { o.flags = 2; }).starts_with("flags"));
  EXPECT_TRUE(error_of([](Options& o) { o.certificate = "own.pem"; }).starts_with("key"));
  EXPECT_TRUE(error_of([](Options& o) { o.key = "own.key"; }).starts_with("certificate"));
  // What would be sent otherwise than it was given.
  static const std::string long_token(protocol::kMaxToken + 1, 'a');
  EXPECT_TRUE(error_of([](Options& o) { o.token = long_token.c_str(); }).starts_with("token"));
  EXPECT_TRUE(error_of([](Options& o) { o.token = "abc\n"; }).starts_with("token"));
  EXPECT_TRUE(error_of([](Options& o) {
                o.tenant =
                    "st\xfc"
                    "dio";
              }).starts_with("tenant"));
  EXPECT_TRUE(error_of([](Options& o) { o.scene = "a\tb"; }).starts_with("scene"));
}

TEST(CErrors, CamerasThatAreNone) {
  FakeServer server(host);
  Client client{Wanted(server.address())};
  const gnomon_camera fine = camera_at(0);
  EXPECT_EQ(gnomon_look(client.handle, &fine, nullptr), GNOMON_NOT_OPEN) << "not yet";
  ASSERT_EQ(client.wait(), GNOMON_OK) << client.error();
  gnomon_camera camera = fine;
  camera.orientation[3] = 2;
  EXPECT_EQ(gnomon_look(client.handle, &camera, nullptr), GNOMON_BAD_ARGUMENT);
  camera = fine;
  camera.position[1] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(gnomon_look(client.handle, &camera, nullptr), GNOMON_BAD_ARGUMENT);
  camera = fine;
  camera.tan_left = -camera.tan_right;
  EXPECT_EQ(gnomon_look(client.handle, &camera, nullptr), GNOMON_BAD_ARGUMENT);
  EXPECT_EQ(gnomon_look(client.handle, &fine, nullptr), GNOMON_OK) << client.error();
  for (const float fov : {0.0f, -1.0f, 3.2f, std::numeric_limits<float>::quiet_NaN()}) {
    EXPECT_EQ(gnomon_camera_perspective(&camera, fov, 16, 9, 0, 0), GNOMON_BAD_ARGUMENT) << fov;
  }
}

// ---- sizes

TEST(CErrors, AStructOfAWrongSizeIsNotTouched) {
  Wanted wanted({"127.0.0.1", 1});
  Client client(wanted);
  for (const size_t size : {size_t{0}, size_t{8}, size_t{1} << 40}) {
    gnomon_session session;
    std::memset(&session, 0x55, sizeof session);
    session.size = size;
    const gnomon_session before = session;
    EXPECT_EQ(gnomon_get_session(client.handle, &session), GNOMON_BAD_ARGUMENT) << size;
    EXPECT_EQ(std::memcmp(&session, &before, sizeof session), 0) << size;
    EXPECT_TRUE(contains(client.error(), "sizeof gnomon_session")) << client.error();
    wanted.options.size = size;
    EXPECT_EQ(Client(wanted).opened, GNOMON_BAD_ARGUMENT) << size;
  }
}

// A struct as a program has it that was built with a later header.
template <class Struct>
struct Later {
  Struct known{};
  uint64_t added = 0;
};

TEST(CErrors, AStructOfALaterVersionIsTakenAsFarAsItIsKnown) {
  FakeServer server(host);
  const Wanted wanted(server.address());
  Later<gnomon_options> options{wanted.options, 0};
  options.known.size = sizeof options;
  options.added = 1;
  {
    Client wants_too_much(&options.known);
    EXPECT_EQ(wants_too_much.opened, GNOMON_BAD_ARGUMENT);
    EXPECT_TRUE(contains(wants_too_much.error(), "later version")) << wants_too_much.error();
  }
  options.added = 0;
  Client client(&options.known);
  ASSERT_EQ(client.wait(), GNOMON_OK) << client.error();
  Later<gnomon_session> session{{}, 99};
  session.known.size = sizeof session;
  ASSERT_EQ(gnomon_get_session(client.handle, &session.known), GNOMON_OK) << client.error();
  EXPECT_EQ(session.known.width, kGrid.width);
  EXPECT_EQ(session.known.size, sizeof session);
  EXPECT_EQ(session.added, 0u);
}

// ---- time

TEST(CErrors, PollWaitsAsLongAsItIsToldAndNoLonger) {
  FakeServer server(host);
  Client client{Wanted(server.address())};
  gnomon_mask* mask = nullptr;
  ASSERT_EQ(client.wait(), GNOMON_OK) << client.error();
  const auto polled_for = [&](uint32_t ms) {
    const auto begin = std::chrono::steady_clock::now();
    EXPECT_EQ(gnomon_poll(client.handle, ms, &mask), GNOMON_NOTHING);
    return std::chrono::steady_clock::now() - begin;
  };
  EXPECT_GE(polled_for(150), 150ms);
  EXPECT_LT(polled_for(150), 5s);
  EXPECT_LT(polled_for(0), 100ms);
}

TEST(CErrors, WaitingForASilentServerEndsInTime) {
  FakeServer server([](Peer& peer) {
    peer.read();
    peer.read();  // the client ends
  });
  Wanted wanted(server.address());
  wanted.options.open_timeout_ms = 300;
  Client client(wanted);
  EXPECT_EQ(client.wait(0), GNOMON_NOTHING);
  EXPECT_EQ(client.wait(20), GNOMON_NOTHING);
  EXPECT_EQ(client.state(), GNOMON_CONNECTING);
  EXPECT_EQ(client.wait(), GNOMON_FAILED);
  EXPECT_TRUE(contains(client.error(), "no answer from")) << client.error();
}

TEST(CErrors, AClosedClientRemainsClosedAndReadable) {
  FakeServer server(host);
  Client client{Wanted(server.address())};
  ASSERT_EQ(client.wait(), GNOMON_OK) << client.error();
  EXPECT_EQ(gnomon_close(client.handle, nullptr), GNOMON_OK);
  EXPECT_EQ(gnomon_close(client.handle, nullptr), GNOMON_OK) << "twice is fine";
  const gnomon_camera camera = camera_at(0);
  gnomon_mask* mask = nullptr;
  EXPECT_EQ(gnomon_look(client.handle, &camera, nullptr), GNOMON_CLOSED);
  EXPECT_EQ(gnomon_poll(client.handle, kPatienceMs, &mask), GNOMON_CLOSED);
  EXPECT_EQ(client.wait(), GNOMON_CLOSED);
  EXPECT_EQ(client.state(), GNOMON_ENDED);
  gnomon_scene scene{};
  scene.size = sizeof scene;
  ASSERT_EQ(gnomon_get_scene(client.handle, &scene), GNOMON_OK);
  EXPECT_STREQ(scene.name, "little");
}

// ---- exceptions

// While it exists, no file can be opened.
class NoDescriptors {
 public:
  NoDescriptors() {
    getrlimit(RLIMIT_NOFILE, &before_);
    const rlimit none{0, before_.rlim_max};
    setrlimit(RLIMIT_NOFILE, &none);
  }
  ~NoDescriptors() { setrlimit(RLIMIT_NOFILE, &before_); }

 private:
  rlimit before_;
};

TEST(CErrors, WhatTheLibraryBelowThrowsIsAResult) {
  const Wanted wanted({"127.0.0.1", 1});
  gnomon_client* client = nullptr;
  gnomon_result result;
  {
    NoDescriptors here;  // Asio throws if it cannot open an epoll descriptor
    result = gnomon_open(&wanted.options, &client);
  }
  EXPECT_EQ(result, GNOMON_INTERNAL);
  ASSERT_NE(client, nullptr);
  EXPECT_TRUE(contains(gnomon_last_error(client), "open files")) << gnomon_last_error(client);
  EXPECT_EQ(gnomon_wait_open(client, 0), GNOMON_INTERNAL) << "final";
  gnomon_free(client);
}

}  // namespace
}  // namespace gnomon::tests::c
