// An HTTP server for a few trusted operators among untrusted clients. One thread reads all requests, so that a client
// that sends nothing, or a byte at a time, delays nobody; other threads answer them. Requests that are being answered
// are bounded by kMostAnswering. Connections that we wait for are bounded in number and time: when there are too many,
// the oldest is closed.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "common/result.h"
#include "daemon/config/config.h"
#include "daemon/metrics/metrics.h"

namespace gnomon::daemon {

struct Page {
  int status = 200;
  const char* content_type = "text/plain; charset=utf-8";
  std::string body;
};

struct HttpRequest {
  std::string path;  // decoded, without what follows a question mark
  std::string content_type, authorization;
  std::string body;
};

class HttpServer {
 public:
  static constexpr size_t kMostConnections = 256;
  static constexpr size_t kMostAnswering = 64;
  static constexpr std::chrono::seconds kRequestTime{1};  // for a client to send its request

  // Called on the server's threads, several at a time. GET and POST have threads of their own, so that a GET never
  // waits for a POST.
  using Answer = std::function<Page(const HttpRequest&)>;
  struct Answers {
    Answer get;
    Answer post;
  };

  // Error if the port cannot be opened. `metrics` counts connections that are closed before they have asked.
  static Result<std::unique_ptr<HttpServer>> start(const AdminConfig& config, Answers answers, Metrics& metrics);
  ~HttpServer();  // blocks until received requests are answered

  uint16_t port() const;

 private:
  struct Impl;
  explicit HttpServer(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace gnomon::daemon
