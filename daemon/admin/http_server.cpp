#include "daemon/admin/http_server.h"

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/thread_pool.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <charconv>
#include <list>
#include <optional>
#include <thread>
#include <utility>

namespace gnomon::daemon {
namespace {

namespace net = boost::asio;
namespace beast = boost::beast;
namespace http = boost::beast::http;
using net::ip::tcp;
using namespace std::chrono_literals;

constexpr size_t kThreads = 2;  // of each pool: one pool answers GET, the other POST
constexpr size_t kMaxHeader = 8192;
constexpr size_t kMaxRequestBody = 4096;
constexpr auto kResponseTime = 5s;  // for a client to read the answer
constexpr auto kRetryAccept = 100ms;

std::string path_of(std::string_view target) {
  target = target.substr(0, target.find('?'));
  std::string path;
  for (size_t i = 0; i < target.size(); ++i) {
    unsigned code = 0;
    const char* const end = target.data() + i + 3;
    if (target[i] == '%' && i + 2 < target.size() && std::from_chars(end - 2, end, code, 16).ptr == end) {
      path += static_cast<char>(code);
      i += 2;
    } else {
      path += target[i];
    }
  }
  return path;
}

HttpRequest to_request(http::request<http::string_body>&& from) {
  const auto text = [](beast::string_view view) { return std::string(view.data(), view.size()); };
  HttpRequest request;
  request.path = path_of({from.target().data(), from.target().size()});
  request.content_type = text(from[http::field::content_type]);
  request.authorization = text(from[http::field::authorization]);
  request.body = std::move(from.body());
  return request;
}

http::response<http::string_body> to_response(Page page) {
  http::response<http::string_body> response;
  response.result(static_cast<unsigned>(page.status));
  response.set(http::field::content_type, page.content_type);
  response.set(http::field::cache_control, "no-store");
  response.set("X-Content-Type-Options", "nosniff");
  // The page loads nothing from elsewhere, and no other page may embed it.
  response.set("Content-Security-Policy",
               "default-src 'self'; img-src 'self' data:; style-src 'self' 'unsafe-inline'; "
               "frame-ancestors 'none'; base-uri 'none'; form-action 'none'");
  if (page.status == 401) response.set(http::field::www_authenticate, "Bearer");
  response.keep_alive(false);
  response.body() = std::move(page.body);
  response.prepare_payload();
  return response;
}

// The page that answers a request that could not be read; nullopt if the connection failed or ended.
std::optional<Page> complaint(const beast::error_code& error) {
  if (error == http::error::end_of_stream || error == http::error::partial_message) return std::nullopt;
  if (error == http::error::body_limit) return Page{.status = 413, .body = "the body is too long\n"};
  if (error == http::error::header_limit) return Page{.status = 431, .body = "the header is too long\n"};
  if (error.category() != make_error_code(http::error::bad_method).category()) return std::nullopt;
  return Page{.status = 400, .body = "no HTTP request\n"};
}

}  // namespace

struct HttpServer::Impl {
  class Connection;

  Impl(Answers to_answer, Metrics& counts) : answers(std::move(to_answer)), metrics(counts) {}

  Result<void> listen(const AdminConfig& config);
  void accept();
  void make_room();
  void stop();

  const Answers answers;
  Metrics& metrics;
  net::io_context io{1};
  tcp::acceptor acceptor{io};
  uint16_t port = 0;
  net::steady_timer retry{io};
  std::list<Connection*> connections;  // oldest first
  size_t answering = 0;
  bool stopping = false;
  std::thread thread;
  net::thread_pool looking{kThreads}, changing{kThreads};
};

// One request, one answer. Kept alive by its own pending operations.
class HttpServer::Impl::Connection : public std::enable_shared_from_this<Connection> {
 public:
  Connection(tcp::socket socket, Impl& server)
      : stream_(std::move(socket)),
        server_(server),
        place_(server.connections.insert(server.connections.end(), this)) {
    parser_.header_limit(kMaxHeader);
    parser_.body_limit(kMaxRequestBody);
  }
  ~Connection() { leave_list(); }

  enum class State { asking, answering, writing, leaving };
  State state() const { return state_; }

  void close() {
    leave_list();
    stream_.close();
  }

  // The deadline is for the complete request, however slowly its bytes arrive.
  void read() {
    stream_.expires_after(kRequestTime);
    http::async_read(stream_, buffer_, parser_,
                     [self = shared_from_this()](beast::error_code error, size_t) { self->on_request(error); });
  }

 private:
  void on_request(beast::error_code error) {
    if (error == beast::error::timeout) return server_.metrics.report(Fault::admin_timeout);
    if (error) {
      auto page = complaint(error);
      return page ? write(std::move(*page)) : void();
    }
    const http::verb method = parser_.get().method();
    head_ = method == http::verb::head;
    if (method == http::verb::post) return answer(server_.changing, server_.answers.post);
    if (head_ || method == http::verb::get) return answer(server_.looking, server_.answers.get);
    write({.status = 405, .body = "allowed: GET, HEAD, POST\n"});
  }

  void answer(net::thread_pool& pool, const Answer& make_page) {
    if (server_.answering >= kMostAnswering) return write({.status = 503, .body = "too many requests at a time\n"});
    ++server_.answering;
    state_ = State::answering;
    net::post(pool, [self = shared_from_this(), &make_page, request = to_request(parser_.release()),
                     work = net::make_work_guard(server_.io)]() mutable {
      Page page = make_page(request);
      Impl& server = self->server_;
      net::post(server.io, [connection = std::move(self), page = std::move(page)]() mutable {
        --connection->server_.answering;
        connection->write(std::move(page));
      });
    });
  }

  void write(Page page) {
    state_ = State::writing;
    response_ = to_response(std::move(page));
    if (head_) response_.body().clear();
    stream_.expires_after(kResponseTime);
    http::async_write(stream_, response_, [self = shared_from_this()](beast::error_code error, size_t) {
      if (error) return;
      self->state_ = State::leaving;
      beast::error_code ignored;
      self->stream_.socket().shutdown(tcp::socket::shutdown_send, ignored);
      self->stream_.expires_after(kRequestTime);
      if (!self->server_.stopping) self->wait_for_end();
    });
  }

  void leave_list() {
    if (place_) server_.connections.erase(*std::exchange(place_, std::nullopt));
  }

  // Closing the socket while bytes of the client are unread would reset the connection, and the client could lose the
  // answer.
  void wait_for_end() {
    stream_.async_read_some(net::buffer(rest_), [self = shared_from_this()](beast::error_code error, size_t) {
      if (!error) self->wait_for_end();
    });
  }

  beast::tcp_stream stream_;
  Impl& server_;
  std::optional<std::list<Connection*>::iterator> place_;  // nullopt if it is being closed
  State state_ = State::asking;
  bool head_ = false;
  beast::flat_buffer buffer_{kMaxHeader + kMaxRequestBody};
  http::request_parser<http::string_body> parser_;
  http::response<http::string_body> response_;
  std::array<char, 1024> rest_;
};

Result<void> HttpServer::Impl::listen(const AdminConfig& config) {
  beast::error_code error;
  const tcp::endpoint local{net::ip::make_address(config.listen, error), config.port};
  if (!error) acceptor.open(local.protocol(), error);
  if (!error) acceptor.set_option(tcp::acceptor::reuse_address(true), error);
  if (!error) acceptor.bind(local, error);
  if (!error) acceptor.listen(tcp::acceptor::max_listen_connections, error);
  if (!error) {
    port = acceptor.local_endpoint().port();
    return {};
  }
  return Error{"admin.port: TCP " + config.listen + " port " + std::to_string(config.port) +
               " cannot be listened on: " + error.message()};
}

void HttpServer::Impl::accept() {
  acceptor.async_accept([this](beast::error_code error, tcp::socket socket) {
    if (error == net::error::operation_aborted) return;
    if (!error) {
      std::make_shared<Connection>(std::move(socket), *this)->read();
      make_room();
      return accept();
    }
    // Most likely there are no file descriptors left. Waiting clients stay in the kernel's queue until some are free.
    retry.expires_after(kRetryAccept);
    retry.async_wait([this](beast::error_code cancelled) {
      if (!cancelled) accept();
    });
  });
}

// Connections that wait for our answer are not closed, as the delay is ours.
void HttpServer::Impl::make_room() {
  if (connections.size() <= kMostConnections) return;
  const auto oldest = std::find_if(connections.begin(), connections.end(),
                                   [](const Connection* c) { return c->state() != Connection::State::answering; });
  if ((*oldest)->state() == Connection::State::asking) metrics.report(Fault::admin_replaced);
  (*oldest)->close();
}

void HttpServer::Impl::stop() {
  stopping = true;
  acceptor.close();
  retry.cancel();
  for (Connection* connection : std::list(connections)) {
    const Connection::State state = connection->state();
    if (state == Connection::State::asking || state == Connection::State::leaving) connection->close();
  }
}

HttpServer::HttpServer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

Result<std::unique_ptr<HttpServer>> HttpServer::start(const AdminConfig& config, Answers answers,
                                                      Metrics& metrics) {
  auto impl = std::make_unique<Impl>(std::move(answers), metrics);
  if (auto listening = impl->listen(config); !listening) return listening.error();
  impl->accept();
  impl->thread = std::thread([&io = impl->io] { io.run(); });
  return std::unique_ptr<HttpServer>(new HttpServer(std::move(impl)));
}

HttpServer::~HttpServer() {
  net::post(impl_->io, [&impl = *impl_] { impl.stop(); });
  impl_->looking.join();
  impl_->changing.join();
  impl_->thread.join();
}

uint16_t HttpServer::port() const { return impl_->port; }

}  // namespace gnomon::daemon
