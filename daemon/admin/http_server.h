// HTTP for a few operators, with strangers at the door: one thread reads all requests, so that who says nothing, or a
// byte at a time, keeps nobody waiting; others answer them. Whoever waits for us is bounded by kMostAnswering, whoever
// we wait for by number and time: when there are too many the oldest has to go.
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
  static constexpr std::chrono::seconds kRequestTime{1};  // for a client to say what it wants

  // Called by threads of ours, several at a time. Who looks never waits for what those do who change something.
  using Answer = std::function<Page(const HttpRequest&)>;
  struct Answers {
    Answer get;
    Answer post;
  };

  // Error: the port is taken. `metrics`: counts who is turned away.
  static Result<std::unique_ptr<HttpServer>> start(const AdminConfig& config, Answers answers, Metrics& metrics);
  ~HttpServer();  // answers what has been asked

  uint16_t port() const;

 private:
  struct Impl;
  explicit HttpServer(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace gnomon::daemon
