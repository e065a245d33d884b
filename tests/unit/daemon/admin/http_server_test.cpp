// The operators' HTTP server at the level of bytes: what it accepts, and clients that send too much, too little or
// nothing.
#include "daemon/admin/http_server.h"

#include <gtest/gtest.h>

#include <array>
#include <asio/connect.hpp>
#include <asio/io_context.hpp>
#include <asio/ip/tcp.hpp>
#include <asio/read.hpp>
#include <asio/write.hpp>
#include <atomic>
#include <future>
#include <mutex>
#include <thread>

namespace gnomon::daemon {
namespace {

using namespace std::chrono_literals;

class HttpServerTest : public testing::Test {
 protected:
  void SetUp() override {
    const auto answer = [this](const HttpRequest& request) {
      const std::lock_guard lock(mutex_);
      asked_ = request;
      return Page{.body = "you asked for " + request.path};
    };
    const auto act = [this](const HttpRequest& request) {
      ++acting_;
      may_act_.get_future().wait();
      return Page{.status = 202, .body = "did " + request.body};
    };
    auto server = HttpServer::start({}, {answer, act}, metrics_);
    ASSERT_TRUE(server) << server.error().message;
    server_ = std::move(*server);
  }

  class Client {
   public:
    explicit Client(uint16_t port) : socket_(io_) { socket_.connect({asio::ip::address_v4::loopback(), port}); }
    void say(const std::string& bytes) {
      asio::error_code closed;
      asio::write(socket_, asio::buffer(bytes), closed);
    }
    // Everything that arrives until the server closes.
    std::string hear() {
      std::string heard;
      asio::error_code end;
      asio::read(socket_, asio::dynamic_buffer(heard), end);
      return heard;
    }

   private:
    // One for all clients: each io_context takes three descriptors beside the socket's, and a login shell allows 1,024.
    static inline asio::io_context io_;
    asio::ip::tcp::socket socket_;
  };

  Client client() { return Client(server_->port()); }
  std::string answer_to(const std::string& bytes) {
    Client c = client();
    c.say(bytes);
    return c.hear();
  }
  static std::string status_of(const std::string& answer) { return answer.substr(0, answer.find("\r\n")); }

  Metrics metrics_{{"default"}, {}, "test"};
  std::mutex mutex_;
  HttpRequest asked_;
  std::atomic<int> acting_{0};
  std::promise<void> may_act_;
  std::unique_ptr<HttpServer> server_;
};

TEST_F(HttpServerTest, AnswersWhatItIsAsked) {
  const std::string answer =
      answer_to("GET /scenes/my%20room?x=1 HTTP/1.1\r\nHost: x\r\nAuthorization: me\r\n\r\n");
  EXPECT_EQ(status_of(answer), "HTTP/1.1 200 OK");
  EXPECT_TRUE(answer.ends_with("\r\n\r\nyou asked for /scenes/my room")) << answer;
  EXPECT_NE(answer.find("X-Content-Type-Options: nosniff"), std::string::npos);
  EXPECT_EQ(asked_.authorization, "me");
  const std::string head = answer_to("HEAD /a HTTP/1.1\r\nHost: x\r\n\r\n");
  EXPECT_NE(head.find("Content-Length: 16"), std::string::npos) << head;
  EXPECT_TRUE(head.ends_with("\r\n\r\n")) << head;
}

TEST_F(HttpServerTest, WhatIsNoRequestIsAnsweredByItsMistake) {
  EXPECT_EQ(status_of(answer_to("DELETE / HTTP/1.1\r\nHost: x\r\n\r\n")), "HTTP/1.1 405 Method Not Allowed");
  EXPECT_EQ(status_of(answer_to("no such thing\r\n\r\n")), "HTTP/1.1 400 Bad Request");
  EXPECT_EQ(status_of(answer_to(std::string(100, '\0') + "\r\n\r\n")), "HTTP/1.1 400 Bad Request");
  EXPECT_EQ(status_of(answer_to("GET / HTTP/1.1\r\nX: " + std::string(20000, 'x'))),
            "HTTP/1.1 431 Request Header Fields Too Large");
  EXPECT_EQ(status_of(answer_to("POST / HTTP/1.1\r\nContent-Length: 5000\r\n\r\n" + std::string(5000, 'x'))),
            "HTTP/1.1 413 Payload Too Large");
  EXPECT_EQ(acting_, 0);
  EXPECT_EQ(answer_to("%/%g%2 HTTP/1.1\r\n\r\n").substr(0, 12), "HTTP/1.1 400");
}

TEST_F(HttpServerTest, PercentSignsThatMeanNothingStay) {
  EXPECT_TRUE(answer_to("GET /%/%zz/%4 HTTP/1.1\r\n\r\n").ends_with("for /%/%zz/%4"));
}

TEST_F(HttpServerTest, WhoSaysNothingIsClosedAndSoIsWhoSaysItSlowly) {
  Client silent = client(), slow = client();
  std::atomic<bool> closed{false};
  std::thread dripping([&] {
    slow.say("GET /");
    while (!closed) {
      slow.say("x");
      std::this_thread::sleep_for(50ms);
    }
  });
  EXPECT_EQ(silent.hear(), "");
  EXPECT_EQ(slow.hear(), "");
  closed = true;
  dripping.join();
  EXPECT_EQ(metrics_.count_of(Fault::admin_timeout), 2u);
}

TEST_F(HttpServerTest, TooManyConnectionsPushOutTheirOldest) {
  std::vector<std::unique_ptr<Client>> silent;
  for (size_t i = 0; i < HttpServer::kMostConnections + 44; ++i) {
    silent.push_back(std::make_unique<Client>(server_->port()));
  }
  EXPECT_TRUE(answer_to("GET /late HTTP/1.1\r\n\r\n").ends_with("for /late"));
  EXPECT_EQ(silent.front()->hear(), "");
  EXPECT_EQ(silent.back()->hear(), "");
  // The connections that were not replaced may have timed out before the last ones arrived.
  const uint64_t replaced = metrics_.count_of(Fault::admin_replaced),
                 late = metrics_.count_of(Fault::admin_timeout);
  EXPECT_LE(replaced, 45u);
  EXPECT_GT(replaced + late, 45u);
}

TEST_F(HttpServerTest, WhoLooksDoesNotWaitForThoseWhoChangeSomething) {
  Client acting = client();
  acting.say("POST / HTTP/1.1\r\nContent-Length: 2\r\n\r\nit");
  while (acting_ == 0) std::this_thread::sleep_for(1ms);
  EXPECT_TRUE(answer_to("GET /meanwhile HTTP/1.1\r\n\r\n").ends_with("for /meanwhile"));
  may_act_.set_value();
  EXPECT_TRUE(acting.hear().ends_with("\r\n\r\ndid it"));
}

TEST_F(HttpServerTest, WhatWasAskedIsAnsweredBeforeItEnds) {
  Client acting = client(), silent = client();
  acting.say("POST / HTTP/1.1\r\nContent-Length: 4\r\n\r\nlast");
  while (acting_ == 0) std::this_thread::sleep_for(1ms);
  std::thread ending([&] { server_.reset(); });
  EXPECT_EQ(silent.hear(), "") << "it is not waited for";
  may_act_.set_value();
  EXPECT_TRUE(acting.hear().ends_with("did last"));
  ending.join();
}

TEST_F(HttpServerTest, APortThatIsTakenIsAnError) {
  const auto second = HttpServer::start({.port = server_->port()}, {}, metrics_);
  ASSERT_FALSE(second);
  EXPECT_NE(second.error().message.find("admin.port"), std::string::npos);
}

}  // namespace
}  // namespace gnomon::daemon
