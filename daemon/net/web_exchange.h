// A browser's connection as long as it speaks HTTP: one request after the other is answered, until one goes on as a
// WebSocket or the browser leaves. A stranger among the pending connections, whose time is bounded by its progress.
#pragma once

#include <asio/awaitable.hpp>
#include <asio/io_context.hpp>

#include <memory>
#include <optional>
#include <stop_token>

#include "common/token_buckets.h"
#include "daemon/net/net_shared.h"
#include "daemon/net/pending_connections.h"
#include "daemon/security/allowed_hosts.h"
#include "daemon/web/progress.h"
#include "daemon/web/scene_pages.h"
#include "daemon/web/web_request.h"
#include "daemon/web/web_response.h"

namespace gnomon::daemon {

// Belongs to its stream, and so to the net thread; outlived by everything that it refers to.
class WebExchange : public BrowserListener, public std::enable_shared_from_this<WebExchange> {
 public:
  // Precondition: `shared.web` is set. `requests`: what each address may still ask the net thread for.
  WebExchange(const NetShared& shared, asio::io_context& io, PendingConnections& pending, ControlStream& stream,
              TokenBuckets<ClientNetwork>& requests);

  void on_open() override;
  void on_bytes(std::span<const uint8_t> bytes) override;
  void on_sent(size_t bytes) override;
  void on_end() override { departure_.request_stop(); }
  bool is_idle() const override { return !answering_ && reader_.size() == 0; }

 private:
  void answer_requests();
  void answer(const web::Request& request);
  double cost_of(const web::Request& request) const;
  void answer_later(const web::Request& request, const web::SceneTarget& target);
  asio::awaitable<void> await_scene(std::shared_ptr<ControlStream> stream, web::Request request,
                                    web::SceneTarget target);
  // nullopt: the request is about a scene.
  std::optional<web::Response> response_to(const web::Request& request) const;
  void respond(const web::Request& request, const web::Response& response);
  void leave();
  void set_deadline();

  const NetShared& shared_;
  asio::io_context& io_;
  PendingConnections& pending_;
  ControlStream& stream_;
  TokenBuckets<ClientNetwork>& requests_;
  AllowedHosts hosts_;
  web::RequestReader reader_;
  web::Progress progress_;
  bool answering_ = false;  // the next request is read when this one is answered
  bool leaving_ = false;    // once the answer is sent
  std::stop_source departure_;
};

}  // namespace gnomon::daemon
