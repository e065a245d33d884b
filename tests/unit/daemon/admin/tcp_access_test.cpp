// Who gets what from the admin server over TCP, in virtual time.
#include "daemon/admin/tcp_access.h"

#include <gtest/gtest.h>

namespace gnomon::daemon {
namespace {

using namespace std::chrono_literals;

constexpr const char* kToken = "0123456789abcdef";

class TcpAccessTest : public testing::Test {
 protected:
  TcpAccessTest() { token_.publish(hash_of(kToken)); }

  static Caller local() {
    return {.address = "127.0.0.1:40000",
            .network = "127.0.0.1",
            .reached = {"127.0.0.1", 7601, false},
            .on_loopback = true};
  }
  static Caller remote() {
    return {.address = "192.0.2.9:40000", .network = "192.0.2.9", .reached = {"192.0.2.1", 7601, true}};
  }
  static HttpRequest get(const std::string& path, Caller caller = local()) {
    const std::string host = caller.reached.address + ":7601";
    return {.changes = false,
            .path = path,
            .host = host,
            .origin = {},
            .content_type = {},
            .authorization = {},
            .body = {},
            .caller = std::move(caller)};
  }
  static HttpRequest post(const std::string& token, Caller caller = local()) {
    HttpRequest request = get("/drain", std::move(caller));
    request.changes = true;
    if (!token.empty()) request.authorization = "Bearer " + token;
    return request;
  }
  // The status of the refusal; 0: it may go on.
  int status_of(const HttpRequest& request) {
    const auto page = access_.refuse(request, now_);
    return page ? page->status : 0;
  }

  Metrics metrics_{{"default"}, {}, "test"};
  Published<OperatorToken> token_;
  TcpAccess access_{{"node7", "proxy.example:443"}, "/run/gnomon/admin.sock", token_, metrics_};
  TimePoint now_{1h};
};

TEST_F(TcpAccessTest, ItAnswersToItsOwnNamesAlone) {
  for (const char* ours : {"127.0.0.1:7601", "localhost:7601", "LOCALHOST:7601", "node7", "Node7:7601", "node7:1",
                           "proxy.example:443"}) {
    HttpRequest request = get("/metrics");
    request.host = ours;
    EXPECT_EQ(status_of(request), 0) << ours;
  }
  for (const char* foreign :
       {"", "attacker.example", "attacker.example:7601", "127.0.0.1", "127.0.0.1:80", "localhost", "192.0.2.1:7601",
        "127.0.0.1.attacker.example:7601", "localhost.attacker.example:7601", "127.0.0.1:7601@attacker.example",
        "proxy.example:7601", "[::1]:7601", ":7601", "[", "[127.0.0.1:7601"}) {
    for (const char* path : {"/metrics", "/status", "/", "/healthz"}) {
      HttpRequest request = get(path);
      request.host = foreign;
      EXPECT_EQ(status_of(request), 403) << foreign;
    }
  }
}

TEST_F(TcpAccessTest, AnAddressOfIpv6StandsInBrackets) {
  Caller caller = local();
  caller.reached.address = "::1";
  HttpRequest request = get("/status", caller);
  request.host = "[::1]:7601";
  EXPECT_EQ(status_of(request), 0);
  request.host = "[::1]";
  EXPECT_EQ(status_of(request), 403) << "port 80";
}

TEST_F(TcpAccessTest, PagesOfOthersAskNothing) {
  for (const char* foreign :
       {"http://attacker.example:7601", "http://attacker.example", "null", "http://127.0.0.1:3000",
        "https://127.0.0.1:7601", "http://127.0.0.1", "127.0.0.1:7601", "file://"}) {
    HttpRequest request = post(kToken);
    request.origin = foreign;
    EXPECT_EQ(status_of(request), 403) << foreign;
  }
  HttpRequest request = post(kToken);
  request.origin = "http://127.0.0.1:7601";
  EXPECT_EQ(status_of(request), 0) << "the operators' page";
  request = post(kToken, remote());
  request.origin = "https://192.0.2.1:7601";
  EXPECT_EQ(status_of(request), 0);
  request.origin = "http://192.0.2.1:7601";
  EXPECT_EQ(status_of(request), 403) << "in clear";
}

TEST_F(TcpAccessTest, ChangesNeedTheTokenAndReadingDoesNotButForTheStatusOffLoopback) {
  EXPECT_EQ(status_of(post("")), 401);
  EXPECT_EQ(status_of(post(kToken)), 0);
  EXPECT_EQ(status_of(get("/status")), 0);
  EXPECT_EQ(status_of(get("/status", remote())), 401);
  EXPECT_EQ(status_of(get("/lights", remote())), 401);
  for (const char* open : {"/", "/page.js", "/metrics", "/healthz", "/readyz"}) {
    EXPECT_EQ(status_of(get(open, remote())), 0) << open;
  }
  HttpRequest shown = get("/status", remote());
  shown.authorization = std::string("Bearer ") + kToken;
  EXPECT_EQ(status_of(shown), 0);
}

TEST_F(TcpAccessTest, WithoutAConfiguredTokenNothingIsChangedAndTheAnswerNamesAWay) {
  token_.publish(std::nullopt);
  const auto page = access_.refuse(post(kToken), now_);
  ASSERT_TRUE(page);
  EXPECT_EQ(page->status, 403);
  EXPECT_NE(page->body.find("/run/gnomon/admin.sock"), std::string::npos) << page->body;
  EXPECT_NE(page->body.find("admin.token_file"), std::string::npos) << page->body;
}

TEST_F(TcpAccessTest, WhoGuessesWaitsTwiceAsLongEachTimeAndOthersDoNot) {
  for (uint32_t i = 0; i < TokenBackoff::kFree; ++i) EXPECT_EQ(status_of(post("guess")), 401);
  auto wait = 1s;
  for (int round = 0; round < 5; ++round, wait *= 2) {
    EXPECT_EQ(status_of(post("guess")), 401);
    const auto page = access_.refuse(post(kToken), now_);
    ASSERT_TRUE(page) << "the right one has to wait too, or guessing would go on";
    EXPECT_EQ(page->status, 429);
    EXPECT_EQ(page->retry_after, wait);
    EXPECT_EQ(status_of(post(kToken, remote())), 0) << "from elsewhere";
    now_ += wait;
  }
  EXPECT_EQ(status_of(post(kToken)), 0);
  EXPECT_EQ(status_of(post("guess")), 401) << "and it begins anew";
  EXPECT_EQ(status_of(post(kToken)), 0);
}

TEST_F(TcpAccessTest, ThreeHundredGuessesAtOnceAreFourThatAreLookedAtAndOneSeries) {
  int looked_at = 0;
  for (int i = 0; i < 300; ++i) looked_at += status_of(post("guess" + std::to_string(i))) == 401;
  EXPECT_EQ(looked_at, static_cast<int>(TokenBackoff::kFree) + 1);
  EXPECT_EQ(metrics_.count_of(Fault::admin_wrong_token), TokenBackoff::kFree + 1);
  EXPECT_EQ(metrics_.count_of(Fault::admin_backoff), 300u - TokenBackoff::kFree - 1);
}

TEST_F(TcpAccessTest, ShowingNoTokenIsNoGuess) {
  for (int i = 0; i < 20; ++i) EXPECT_EQ(status_of(post("")), 401);
  EXPECT_EQ(status_of(post(kToken)), 0);
}

TEST(TokenBackoff, NobodyWaitsLongerThanTheLongestAndOldMistakesAreForgotten) {
  TokenBackoff backoff;
  TimePoint now(1h);
  for (int i = 0; i < 100; ++i) {
    now += backoff.wait("a", now).value_or(0s);
    backoff.wrong("a", now);
  }
  EXPECT_EQ(backoff.wait("a", now), TokenBackoff::kLongest);
  now += TokenBackoff::kForgotten + 1s;
  backoff.wrong("a", now);
  EXPECT_EQ(backoff.wait("a", now), std::nullopt);
}

TEST(TokenBackoff, ItsTableIsBoundedAndAFloodOfAddressesFreesNobodyWhoWaits) {
  TokenBackoff backoff;
  const TimePoint now(1h);
  for (int i = 0; i < 10; ++i) backoff.wrong("guesser", now);
  for (size_t i = 0; i < 2 * TokenBackoff::kMostNetworks; ++i) backoff.wrong(std::to_string(i), now);
  EXPECT_EQ(backoff.size(), TokenBackoff::kMostNetworks);
  EXPECT_TRUE(backoff.wait("guesser", now));
}

}  // namespace
}  // namespace gnomon::daemon
