// An HTTP server for a few trusted operators among untrusted clients. One thread reads all requests, so that a client
// that sends nothing, or a byte at a time, delays nobody; other threads answer them. Requests that are being answered
// are bounded by kMostAnswering. Connections that we wait for are bounded in number and time: when there are too many,
// the oldest is closed.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "common/clock.h"
#include "common/result.h"
#include "daemon/admin/http_message.h"
#include "daemon/admin/unix_socket.h"
#include "daemon/config/config.h"
#include "daemon/metrics/metrics.h"

namespace gnomon::daemon {

struct HttpTls;

// TLS 1.3 with the certificate and key that the files hold. The error names the key of the configuration.
Result<std::shared_ptr<HttpTls>> open_http_tls(const AdminTlsConfig& files);

class HttpServer {
 public:
  static constexpr size_t kMostConnections = 256;
  static constexpr size_t kMostAnswering = 64;
  static constexpr std::chrono::seconds kRequestTime{1};  // for a client to send its request

  using Answer = std::function<Page(const HttpRequest&)>;
  struct Answers {
    // Called on the server's threads, several at a time. GET and POST have threads of their own, so that a GET never
    // waits for a POST.
    Answer get;
    Answer post;
    // Called before, on the thread that reads: the answer to a request that goes no further, nullopt for the others.
    std::function<std::optional<Page>(const HttpRequest&, TimePoint)> refuse = {};
  };

  struct Listening {
    std::string listen = "127.0.0.1";
    uint16_t port = 0;                             // 0: a free one
    std::shared_ptr<HttpTls> tls = nullptr;        // of TCP; nullptr: none is spoken
    std::unique_ptr<UnixSocket> socket = nullptr;  // nullptr: none
  };

  // Error if the port cannot be opened. `metrics` counts connections that are closed before they have asked.
  static Result<std::unique_ptr<HttpServer>> start(Listening listening, Answers answers, Metrics& metrics);
  ~HttpServer();  // blocks until received requests are answered

  uint16_t port() const;
  // For new connections; has no effect on a server that speaks none. Any thread.
  void set_tls(std::shared_ptr<HttpTls> tls);

 private:
  struct Impl;
  explicit HttpServer(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace gnomon::daemon
