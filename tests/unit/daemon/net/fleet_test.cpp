// One node of a fleet, as its door sees it: the door port, and connections that come through a proxy.
#include <asio/read.hpp>

#include "daemon/ctl/admin_client.h"
#include "tests/unit/daemon/net/proxy_bytes.h"
#include "tests/unit/daemon/net/served.h"

namespace gnomon::daemon {
namespace {

using namespace std::chrono_literals;

class Fleet : public Served {
 protected:
  void SetUp() override {
    Served::SetUp();
    config_.fleet.door_listen = "127.0.0.1";
    config_.fleet.door_port = 0;
    frame_time_ = 2ms;
  }

  // What the door port says to `question`, up to the end of the connection.
  std::string asked(const std::string& question) {
    asio::io_context io;
    asio::ip::tcp::socket socket(io);
    socket.connect({asio::ip::address_v4::loopback(), daemon_->server().door_port()});
    asio::write(socket, asio::buffer(question));
    std::string answer;
    asio::error_code end;
    asio::read(socket, asio::dynamic_buffer(answer), end);
    return answer;
  }
  std::string readyz() { return asked("GET /readyz HTTP/1.0\r\nHost: node\r\n\r\n").substr(9, 3); }
  std::string agent() { return asked("agent\n"); }

  ctl::AdminClient admin() { return ctl::AdminClient({.address = "unix:" + daemon_->admin().socket().string()}); }
  double load() { return admin().status()->at("devices").at(0).at("load"); }

  // A session that asks for so many frames of 2 ms a second, which is known once it has got one.
  std::unique_ptr<TestClient> join(float rate_hz) {
    auto joined = std::make_unique<TestClient>(daemon_->control_port());
    auto hello = TestClient::hello(kScene);
    hello.rate_hz = rate_hz;
    EXPECT_TRUE(joined->join(hello));
    joined->send_view(1, 1);
    EXPECT_FALSE(joined->receive_frame(1).empty());
    return joined;
  }

  std::unique_ptr<TestClient> through_proxy(const std::string& client) {
    return std::make_unique<TestClient>(daemon_->control_port(), std::function<void(SSL*)>(), proxy_bytes(client));
  }
  // Of one without datagrams, whose address is that of its control connection.
  std::string address_of(TestClient& session) {
    session.send_view_by_control(1, 1);
    EXPECT_FALSE(session.receive_frame_by_control(1).empty());
    std::string address;
    eventually([&] {
      const auto sessions = admin().status()->at("sessions");
      if (!sessions.empty()) address = sessions.at(0).at("address");
      return !address.empty();
    });
    return address;
  }
};

TEST_F(Fleet, ThereIsNoDoorPortUnlessOneIsAskedFor) {
  config_.fleet.door_listen = "";
  start();
  EXPECT_EQ(daemon_->server().door_port(), 0);
  EXPECT_EQ(daemon_->metrics().text().find("gnomon_door_questions_total"), std::string::npos);
}

TEST_F(Fleet, ADrainingNodeTakesNobodyAndIsNotBroken) {
  start();
  EXPECT_EQ(readyz(), "200");
  EXPECT_EQ(agent(), "ready up 100%\n");
  EXPECT_TRUE(eventually([&] { return metrics_say("gnomon_door_questions_total 2"); }));
  ASSERT_TRUE(admin().post("/drain"));
  EXPECT_EQ(agent(), "drain\n");
  EXPECT_EQ(readyz(), "200") << "else the door would cut the sessions that are still served";
  ASSERT_TRUE(admin().post("/undrain"));
  EXPECT_EQ(agent(), "ready up 100%\n");
}

TEST_F(Fleet, OtherQuestionsAreAnsweredToo) {
  start();
  EXPECT_EQ(asked("GET /status HTTP/1.1\r\n\r\n").substr(9, 3), "404");
  EXPECT_EQ(asked("GET /readyz HTTP/1.1\r\n\r\n").substr(9, 3), "200");
  EXPECT_EQ(asked("what\n").substr(9, 3), "404");
  EXPECT_EQ(asked(std::string(10'000, 'x')), "") << "too long a question";
}

TEST_F(Fleet, ANodeIsFullByWhatItsSessionsArePredictedToNeed) {
  start();
  EXPECT_EQ(load(), 0);
  const auto first = join(400);
  EXPECT_TRUE(eventually([&] { return std::abs(load() - 0.8) < 0.01; })) << load();
  EXPECT_EQ(agent(), "ready up 100%\n");
  const auto second = join(50);
  EXPECT_TRUE(eventually([&] { return std::abs(load() - 0.9) < 0.01; })) << load();
  EXPECT_EQ(agent(), "ready up 1%\n");
  EXPECT_TRUE(eventually([&] { return metrics_say("gnomon_load_ratio 0.9"); }));
  second->send(protocol::Bye{});
  EXPECT_TRUE(eventually([&] { return std::abs(load() - 0.8) < 0.01; })) << load();
  EXPECT_EQ(agent(), "ready up 1%\n") << "it is not below 75% yet";
  first->send(protocol::Bye{});
  EXPECT_TRUE(eventually([&] { return load() == 0; }));
  EXPECT_EQ(agent(), "ready up 100%\n");
}

TEST_F(Fleet, ASessionWithoutARateCountsAtTheAssumedOne) {
  config_.fleet.assumed_rate_hz = 25;
  start();
  const auto greedy = join(0);
  EXPECT_TRUE(eventually([&] { return std::abs(load() - 0.05) < 0.001; })) << load();
}

TEST_F(Fleet, AProxysConnectionsAreItsClients) {
  config_.server.proxies = {"127.0.0.1"};
  config_.server.max_sessions_per_address = 1;
  start();
  const auto first = through_proxy("192.0.2.7");
  ASSERT_TRUE(first->join(TestClient::hello(kScene), false)) << "without datagrams, which come from elsewhere";
  EXPECT_EQ(address_of(*first), "192.0.2.7");
  const auto again = through_proxy("192.0.2.7");
  again->send(TestClient::hello(kScene));
  const auto refused = again->receive_a<protocol::Refused>();
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->code, protocol::RefusalCode::too_many_sessions);
  EXPECT_TRUE(through_proxy("192.0.2.8")->join(TestClient::hello(kScene), false))
      << "another client of the same proxy";
}

TEST_F(Fleet, AProxysConnectionBeginsWithAHeader) {
  config_.server.proxies = {"127.0.0.1"};
  config_.server.handshake_timeout = 200ms;
  start();
  EXPECT_FALSE(client().shook_hands());
  EXPECT_EQ(count_of(Fault::proxy_header), 1u);
  auto local = proxy_bytes("192.0.2.7");
  local[12] = 0x20;
  EXPECT_TRUE(TestClient(daemon_->control_port(), {}, local).shook_hands()) << "the proxy's own";
  asio::io_context io;
  asio::ip::tcp::socket silent(io);
  silent.connect({asio::ip::address_v4::loopback(), daemon_->control_port()});
  EXPECT_TRUE(eventually([&] { return count_of(Fault::proxy_header) == 2; })) << "one that says nothing is closed";
}

TEST_F(Fleet, ADoorThatIsNotListedIsNamed) {
  config_.server.proxies = {"192.0.2.1"};
  start();
  testing::internal::CaptureStderr();
  EXPECT_FALSE(through_proxy("192.0.2.7")->shook_hands());
  const std::string version_1 = "PROXY TCP4 192.0.2.7 192.0.2.1 12345 7600\r\n";
  EXPECT_FALSE(TestClient(daemon_->control_port(), {}, {version_1.begin(), version_1.end()}).shook_hands());
  EXPECT_TRUE(eventually([&] { return count_of(Fault::proxy_unlisted) == 2; }));
  EXPECT_EQ(count_of(Fault::tls_failed), 0u);
  const std::string logged = testing::internal::GetCapturedStderr();
  EXPECT_NE(logged.find("server.proxies"), std::string::npos) << logged;
  EXPECT_NE(logged.find("address=127.0.0.1"), std::string::npos) << logged;
  EXPECT_EQ(logged.find("192.0.2.7"), std::string::npos) << "what a stranger says of others is not believed";
  EXPECT_TRUE(client().shook_hands()) << "those who come without a header are clients";
}

TEST_F(Fleet, AClientIsToldWhereTheNodeItselfIs) {
  config_.server.public_address = "127.0.0.1";
  start();
  auto aware = TestClient::hello(kScene);
  aware.features |= protocol::kFeatureFleet;
  auto knows = client(), does_not = client();
  ASSERT_TRUE(knows.join(aware));
  EXPECT_EQ(knows.welcome().data_host, "127.0.0.1");
  EXPECT_EQ(knows.welcome().home_host, "127.0.0.1");
  EXPECT_EQ(knows.welcome().home_port, daemon_->control_port());
  ASSERT_TRUE(does_not.join(TestClient::hello(kScene)));
  EXPECT_EQ(does_not.welcome().features & protocol::kFeatureFleet, 0u);
}

TEST_F(Fleet, ANodeThatDrainsAsksTheClientsOfAFleetToMove) {
  config_.server.public_address = "127.0.0.1";
  start();
  auto aware = TestClient::hello(kScene);
  aware.features |= protocol::kFeatureFleet;
  auto moves = client(), stays = client(), knows_no_fleet = client();
  ASSERT_TRUE(moves.join(aware));
  ASSERT_TRUE(stays.join(aware));
  ASSERT_TRUE(knows_no_fleet.join(TestClient::hello(kScene)));
  ASSERT_TRUE(admin().post("/drain"));
  const protocol::Draining go{protocol::Draining::kNoDeadline, protocol::Draining::kMoveNow};
  EXPECT_EQ(moves.receive_a<protocol::Draining>(), go);
  EXPECT_EQ(stays.receive_a<protocol::Draining>(), go);
  moves.send(protocol::Bye{"moved"});
  EXPECT_TRUE(eventually([&] { return metrics_say("gnomon_session_moves_total{outcome=\"left\"} 1"); }));
  EXPECT_TRUE(metrics_say("gnomon_session_moves_total{outcome=\"asked\"} 2"));
  ASSERT_TRUE(admin().post("/undrain"));
  EXPECT_EQ(stays.receive_a<protocol::Draining>(), protocol::Draining{protocol::Draining::kNoDeadline})
      << "taken back";
  stays.send(protocol::Bye{});
  EXPECT_TRUE(eventually([&] { return admin().status()->at("sessions").size() == 1; }));
  EXPECT_TRUE(metrics_say("gnomon_session_moves_total{outcome=\"left\"} 1")) << "one that stayed has not moved";
  EXPECT_TRUE(metrics_say("gnomon_session_moves_total{outcome=\"kept\"} 1"));
  std::thread stopping([&] { daemon_->drain(); });
  const auto told = knows_no_fleet.receive_a<protocol::Draining>();
  EXPECT_TRUE(told && !told->move_now()) << "it is the first that it hears, and it has no door to ask";
  stopping.join();
}

TEST_F(Fleet, WhoStaysOnANodeThatStopsIsCounted) {
  config_.server.public_address = "127.0.0.1";
  start();  // deadline: now
  auto aware = TestClient::hello(kScene);
  aware.features |= protocol::kFeatureFleet;
  auto stays = client();
  ASSERT_TRUE(stays.join(aware));
  const std::string stayed = "gnomon_session_moves_total{outcome=\"stayed\"} ";
  EXPECT_TRUE(metrics_say(stayed + "0"));
  daemon_->drain();
  EXPECT_EQ(stays.receive_a<protocol::Draining>(), (protocol::Draining{0, protocol::Draining::kMoveNow}));
  EXPECT_NE(daemon_->metrics().text().find(stayed + "1\n"), std::string::npos);
}

TEST_F(Fleet, ANodeWithoutAPublicAddressIsInNoFleet) {
  start();
  auto aware = TestClient::hello(kScene);
  aware.features |= protocol::kFeatureFleet;
  auto knows = client();
  ASSERT_TRUE(knows.join(aware));
  EXPECT_EQ(knows.welcome().features & protocol::kFeatureFleet, 0u);
}

TEST_F(Fleet, OthersAreNotBelievedToBeProxies) {
  config_.server.proxies = {"192.0.2.1"};
  start();
  EXPECT_FALSE(through_proxy("192.0.2.7")->shook_hands());
  auto direct = client();
  ASSERT_TRUE(direct.join(TestClient::hello(kScene), false));
  EXPECT_EQ(address_of(direct), "127.0.0.1");
}

}  // namespace
}  // namespace gnomon::daemon
