#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "daemon/web/progress.h"
#include "daemon/web/scene_pages.h"
#include "daemon/web/static_files.h"
#include "daemon/web/upgrade.h"
#include "daemon/web/web_request.h"

namespace gnomon::daemon::web {
namespace {

using namespace std::chrono_literals;

void feed(RequestReader& reader, const std::string& text) {
  reader.feed({reinterpret_cast<const uint8_t*>(text.data()), text.size()});
}

std::optional<Request> request_of(RequestReader& reader) {
  auto read = reader.next();
  const auto* request = std::get_if<std::optional<Request>>(&read);
  EXPECT_NE(request, nullptr) << std::get<BadRequest>(read).why;
  return request ? *request : std::nullopt;
}

int refusal_of(const std::string& text) {
  RequestReader reader;
  feed(reader, text);
  auto read = reader.next();
  const auto* bad = std::get_if<BadRequest>(&read);
  return bad ? bad->status : 0;
}

std::string field(const Response& response, const std::string& name) {
  const auto found = std::find_if(response.fields.begin(), response.fields.end(),
                                  [&](const auto& entry) { return entry.first == name; });
  return found == response.fields.end() ? "" : found->second;
}

TEST(WebRequest, ComesInPiecesAndOneAfterTheOther) {
  const std::string two =
      "GET /app.js?v=1 HTTP/1.1\r\nHost: node7:7600\r\nAccept-Encoding: br\r\n\r\n"
      "HEAD / HTTP/1.1\r\nhost: node7\r\nConnection: close\r\n\r\n";
  for (size_t cut = 1; cut < two.size(); ++cut) {
    RequestReader reader;
    std::vector<Request> read;
    for (const std::string& piece : {two.substr(0, cut), two.substr(cut)}) {
      feed(reader, piece);
      while (auto request = request_of(reader)) read.push_back(*request);
    }
    ASSERT_EQ(read.size(), 2u) << cut;
    EXPECT_EQ(read[0].method, Request::Method::get);
    EXPECT_EQ(read[0].target, "/app.js");
    EXPECT_EQ(read[0].host, "node7:7600");
    EXPECT_EQ(read[0].accept_encoding, "br");
    EXPECT_TRUE(read[0].keep_alive);
    EXPECT_EQ(read[1].method, Request::Method::head);
    EXPECT_FALSE(read[1].keep_alive);
    EXPECT_EQ(reader.size(), 0u);
  }
}

TEST(WebRequest, IsRefusedWhereItIsNone) {
  EXPECT_EQ(refusal_of("\x16\x03\x01\r\n\r\n"), 400);
  EXPECT_EQ(refusal_of("GET / HTTP/1.1\r\n\r\n"), 400);                        // names no Host
  EXPECT_EQ(refusal_of("GET / HTTP/1.1\r\nHost: a\r\nHost: b\r\n\r\n"), 400);  // names two
  EXPECT_EQ(refusal_of("GET / HTTP/1.1\r\nHost: a\r\nA : b\r\n\r\n"), 400);
  EXPECT_EQ(refusal_of("GET / HTTP/1.0\r\nHost: a\r\n\r\n"), 505);
  EXPECT_EQ(refusal_of("GET / HTTP/1.1\r\nHost: a\r\nContent-Length: 3\r\n\r\n"), 413);
  EXPECT_EQ(refusal_of("GET / HTTP/1.1\r\nHost: a\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n"), 413);
  EXPECT_EQ(refusal_of("GET / HTTP/1.1\r\nHost: a\r\nX: " + std::string(9000, 'x')), 431);
  EXPECT_EQ(refusal_of("GET /" + std::string(9000, 'x')), 431);
}

Request handshake() {
  RequestReader reader;
  feed(reader,
       "GET /session HTTP/1.1\r\nHost: server.example.com\r\nUpgrade: websocket\r\nConnection: keep-alive, "
       "Upgrade\r\n"
       "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nOrigin: https://server.example.com\r\n"
       "Sec-WebSocket-Protocol: chat, gnomon\r\nSec-WebSocket-Version: 13\r\n\r\nrest");
  Request request = *request_of(reader);
  EXPECT_EQ(reader.take_rest(), (std::vector<uint8_t>{'r', 'e', 's', 't'}));
  return request;
}

TEST(WebUpgrade, AnswersTheExampleOfItsSpecification) {  // RFC 6455, 1.3
  const Response response = upgrade(handshake());
  EXPECT_EQ(response.status, 101);
  EXPECT_EQ(field(response, "Sec-WebSocket-Accept"), "s3pPLMBiTxaQ9kYGzzhZRbK+xOo=");
  EXPECT_EQ(field(response, "Sec-WebSocket-Protocol"), "gnomon");
}

TEST(WebUpgrade, IsForOurOwnPageInVersion13) {
  const auto status = [](auto change) {
    Request request = handshake();
    change(request);
    return upgrade(request).status;
  };
  EXPECT_EQ(status([](Request& r) { r.origin = "https://SERVER.example.com:443"; }), 101);
  EXPECT_EQ(status([](Request& r) { r.origin = ""; }), 403);
  EXPECT_EQ(status([](Request& r) { r.origin = "null"; }), 403);
  EXPECT_EQ(status([](Request& r) { r.origin = "http://server.example.com"; }), 403);
  EXPECT_EQ(status([](Request& r) { r.origin = "https://server.example.com:8443"; }), 403);
  EXPECT_EQ(status([](Request& r) { r.origin = "https://server.example.com.attacker.example"; }), 403);
  EXPECT_EQ(status([](Request& r) { r.websocket_version = "8"; }), 426);
  EXPECT_EQ(status([](Request& r) { r.upgrade = false; }), 426);
  EXPECT_EQ(status([](Request& r) { r.method = Request::Method::head; }), 426);
  EXPECT_EQ(status([](Request& r) { r.websocket_key = "dGhlIHNhbXBsZSBub25jZQ="; }), 400);
  EXPECT_EQ(status([](Request& r) { r.websocket_protocol = "gnomon2"; }), 400);
}

TEST(WebFiles, AreServedOnceAndThenFromTheCache) {
  const std::string text(2000, 'x');
  const auto* const bytes = reinterpret_cast<const uint8_t*>(text.data());
  const EmbeddedFile files[] = {
      {"/index.html", {bytes, 2000}}, {"/main.js", {bytes, 1000}}, {"/tiny.svg", {bytes, 1}}};
  const StaticFiles served = StaticFiles::of(files);
  Request request{.method = Request::Method::get, .target = "/"};
  const Response plain = served.answer(request);
  EXPECT_EQ(plain.status, 200);
  EXPECT_EQ(field(plain, "Content-Type"), "text/html; charset=utf-8");
  EXPECT_EQ(plain.body->size(), 2000u);
  request.accept_encoding = "gzip, deflate, br";
  const Response packed = served.answer(request);
  EXPECT_EQ(field(packed, "Content-Encoding"), "br");
  EXPECT_LT(packed.body->size(), 100u);
  EXPECT_NE(field(packed, "ETag"), field(plain, "ETag"));
  request.if_none_match = "\"another\", W/" + field(packed, "ETag");
  const Response unchanged = served.answer(request);
  EXPECT_EQ(unchanged.status, 304);
  EXPECT_EQ(unchanged.body, nullptr);
  request.accept_encoding = "br;q=0";
  EXPECT_EQ(served.answer(request).status, 200);  // another representation, which it does not have
  EXPECT_EQ(field(served.answer({.target = "/tiny.svg", .accept_encoding = "br"}), "Content-Encoding"), "");
  EXPECT_NE(field(served.answer({.target = "/main.js"}), "ETag"), field(plain, "ETag"));
  EXPECT_EQ(served.answer({.target = "/none"}).status, 404);
  const StaticFiles in_fleet = StaticFiles::of(files, "gnomon.example");
  EXPECT_GT(in_fleet.answer({.target = "/"}).body->size(), 2000u) << "its page says so";
  EXPECT_EQ(in_fleet.answer({.target = "/main.js"}).body->size(), 1000u);
}

TEST(WebFiles, ThePageMayRunTheScriptThatIsInItAndNoOther) {
  const std::string page = "<body><script src=\"start.js\"></script></body>", script = "begin();";
  const auto file = [](const char* path, const std::string& text) {
    return EmbeddedFile{path, {reinterpret_cast<const uint8_t*>(text.data()), text.size()}};
  };
  const EmbeddedFile files[] = {file("/index.html", page), file("/start.js", script)};
  const StaticFiles served = StaticFiles::of(files);
  const Response answer = served.answer({.target = "/"});
  EXPECT_EQ(std::string(answer.body->begin(), answer.body->end()), "<body><script>begin();</script></body>");
  const auto policy = [](const Response& response) {
    const std::vector<uint8_t> header = header_of(response);
    const std::string text(header.begin(), header.end());
    const size_t at = text.find("script-src");
    return text.substr(at, text.find(';', at) - at);
  };
  // printf 'begin();' | openssl dgst -sha256 -binary | base64
  const std::string hash = " 'sha256-RGdiNHrz6SleHp86rY1Pe6UYC/Z2F6aw/rzfvgFU15Q='";
  EXPECT_EQ(policy(answer), "script-src 'self' 'wasm-unsafe-eval'" + hash);
  EXPECT_EQ(policy(served.answer({.target = "/index.html", .if_none_match = "*"})), policy(answer))
      << "also of a 304";
  EXPECT_EQ(policy(served.answer({.target = "/start.js"})), "script-src 'self' 'wasm-unsafe-eval'");
}

TEST(WebScenes, AreAddressedByNameAndByTheHashOfTheirPack) {
  const std::string hash(64, 'a');
  EXPECT_FALSE(scene_target("/scenes/room"));
  EXPECT_EQ(scene_target("/scene/living_room")->name, "living_room");
  EXPECT_EQ(scene_target("/scene/living_room")->sha256, "");
  const auto pack = scene_target("/scene/maps/oa%20dm.glb/" + hash + ".pack");
  EXPECT_EQ(pack->name, "maps/oa dm.glb");
  EXPECT_EQ(pack->sha256, hash);
  EXPECT_EQ(scene_target("/scene/room/" + hash.substr(1) + ".pack")->sha256, "");
  EXPECT_EQ(scene_target("/scene/%2e%2e/%zz%4")->name, "../%zz%4");  // a key of a table, never a path
  const Response page = scene_page("maps/oa dm.glb", hash, 12);
  EXPECT_EQ(std::string(page.body->begin(), page.body->end()),
            R"({"bytes":12,"name":"maps/oa dm.glb","pack":"/scene/maps/oa%20dm.glb/)" + hash +
                R"(.pack","sha256":")" + hash + R"("})");
  EXPECT_EQ(field(page, "Cache-Control"), "no-store");
}

TEST(WebScenes, ComeInBrotliAloneAndAreKept) {
  const auto packed = std::make_shared<const std::vector<uint8_t>>(5);
  const Response response = pack_response({.accept_encoding = "gzip, deflate, br"}, packed);
  EXPECT_EQ(response.body, packed);
  EXPECT_EQ(field(response, "Content-Encoding"), "br");
  EXPECT_EQ(field(response, "Cache-Control"), "private, max-age=31536000, immutable");
  EXPECT_EQ(pack_response({.accept_encoding = "gzip"}, packed).status, 406);
}

TEST(WebScenes, TakeABearersTokenAlone) {
  EXPECT_EQ(bearer_token("Bearer abc"), "abc");
  EXPECT_EQ(bearer_token("bearer abc"), "abc");
  EXPECT_EQ(bearer_token("Basic abc"), "");
  EXPECT_EQ(bearer_token("Bearer "), "");
  EXPECT_EQ(bearer_token(""), "");
}

TEST(WebProgress, SlowButSteadyGoesOnAndDawdlingDoesNot) {
  const TimePoint start{};
  Progress progress(10s, start);
  EXPECT_EQ(progress.deadline(), start + 10s);
  progress.asks(start + 1s);
  EXPECT_EQ(progress.deadline(), start + 11s);
  progress.sent(1'000'000, start + 2s);  // nothing is being answered
  EXPECT_EQ(progress.deadline(), start + 11s);
  progress.waits();
  EXPECT_EQ(progress.deadline(), TimePoint::max());
  // 4 kB a second for an hour: each step's bytes come within the patience.
  TimePoint now = start + 100s;
  progress.answers(now);
  for (int i = 0; i < 3600; ++i) {
    now += 1s;
    ASSERT_LT(now, progress.deadline());
    progress.sent(4096, now);
  }
  // 2 kB a second do not make it.
  progress.answers(now);
  int seconds = 0;
  while (now < progress.deadline()) {
    now += 1s;
    ++seconds;
    progress.sent(2048, now);
  }
  EXPECT_EQ(seconds, 10);
}

}  // namespace
}  // namespace gnomon::daemon::web
