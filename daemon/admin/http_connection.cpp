#include "daemon/admin/http_connection.h"

#include <boost/asio/post.hpp>
#include <charconv>
#include <utility>

#include "common/within_memory.h"
#include "daemon/admin/http_tls.h"

namespace gnomon::daemon {
namespace {

namespace net = boost::asio;
namespace beast = boost::beast;
namespace http = boost::beast::http;
using namespace std::chrono_literals;

constexpr size_t kMaxHeader = 8192;
constexpr size_t kMaxRequestBody = 4096;
constexpr auto kResponseTime = 5s;  // for a client to read the answer

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

HttpRequest to_request(http::request<http::string_body>&& from, const Caller& caller) {
  const auto text = [](beast::string_view view) { return std::string(view.data(), view.size()); };
  HttpRequest request;
  request.changes = from.method() == http::verb::post;
  request.path = path_of({from.target().data(), from.target().size()});
  request.host = text(from[http::field::host]);
  request.origin = text(from[http::field::origin]);
  request.content_type = text(from[http::field::content_type]);
  request.authorization = text(from[http::field::authorization]);
  request.body = std::move(from.body());
  request.caller = caller;
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
  if (page.retry_after) response.set(http::field::retry_after, std::to_string(page.retry_after->count()));
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

HttpConnection::HttpConnection(Socket socket, Caller caller, std::shared_ptr<HttpTls> tls, HttpConnections& all)
    : context_(std::move(tls)),
      stream_(std::move(socket)),
      caller_(std::move(caller)),
      all_(all),
      place_(all.open.insert(all.open.end(), this)),
      buffer_(kMaxHeader + kMaxRequestBody) {
  if (context_) tls_.emplace(stream_, context_->context);
  parser_.header_limit(kMaxHeader);
  parser_.body_limit(kMaxRequestBody);
}

HttpConnection::~HttpConnection() { leave_list(); }

void HttpConnection::leave_list() {
  if (place_) all_.open.erase(*std::exchange(place_, std::nullopt));
}

void HttpConnection::close() {
  leave_list();
  stream_.close();
}

template <class Do>
void HttpConnection::on_stream(Do&& operation) {
  if (tls_) return operation(*tls_);
  operation(stream_);
}

void HttpConnection::begin() {
  if (!tls_) return read();
  stream_.expires_after(HttpServer::kRequestTime);
  tls_->async_handshake(net::ssl::stream_base::server, [self = shared_from_this()](beast::error_code error) {
    if (error == beast::error::timeout) return self->all_.metrics.report(Fault::admin_timeout);
    if (!error) self->read();
  });
}

// The deadline is for the complete request, however slowly its bytes arrive.
void HttpConnection::read() {
  stream_.expires_after(HttpServer::kRequestTime);
  on_stream([this](auto& stream) {
    http::async_read(stream, buffer_, parser_,
                     [self = shared_from_this()](beast::error_code error, size_t) { self->on_request(error); });
  });
}

void HttpConnection::on_request(beast::error_code error) {
  if (error == beast::error::timeout) return all_.metrics.report(Fault::admin_timeout);
  if (error) {
    auto page = complaint(error);
    return page ? write(std::move(*page)) : void();
  }
  const http::verb method = parser_.get().method();
  head_ = method == http::verb::head;
  const bool changes = method == http::verb::post;
  if (!changes && !head_ && method != http::verb::get) {
    return write({.status = 405, .body = "allowed: GET, HEAD, POST\n"});
  }
  HttpRequest request = to_request(parser_.release(), caller_);
  if (all_.answers.refuse) {
    if (auto page = all_.answers.refuse(request, Clock::now())) return write(std::move(*page));
  }
  if (changes) return answer(all_.changing, all_.answers.post, std::move(request));
  answer(all_.looking, all_.answers.get, std::move(request));
}

void HttpConnection::answer(net::thread_pool& pool, const HttpServer::Answer& make_page, HttpRequest request) {
  if (all_.answering >= HttpServer::kMostAnswering) {
    return write({.status = 503, .body = "too many requests at a time\n"});
  }
  ++all_.answering;
  state_ = State::answering;
  net::post(pool, [answered = std::make_unique<Answered>(Answered{shared_from_this(), {}}), &make_page,
                   asked = std::move(request), &io = all_.io, work = net::make_work_guard(all_.io)]() mutable {
    if (!done_or_dropped("an answer", [&] { answered->page = make_page(asked); })) answered->page.status = 503;
    // The last reference has to be dropped on the thread of `io`, which alone knows the open connections: none is left here.
    Answered* const handed_over = answered.release();
    until_memory_suffices(
        [&] { net::post(io, [handed_over] { finish(std::unique_ptr<Answered>(handed_over)); }); });
  });
}

void HttpConnection::finish(std::unique_ptr<Answered> answered) {
  --answered->connection->all_.answering;
  answered->connection->write(std::move(answered->page));
}

void HttpConnection::write(Page page) {
  state_ = State::writing;
  response_ = to_response(std::move(page));
  if (head_) response_.body().clear();
  stream_.expires_after(kResponseTime);
  on_stream([this](auto& stream) {
    http::async_write(stream, response_, [self = shared_from_this()](beast::error_code error, size_t) {
      if (!error) self->leave();
    });
  });
}

// An encrypted answer ends with a close_notify, so that its reader knows that nothing was cut off.
void HttpConnection::leave() {
  state_ = State::leaving;
  const auto half_close = [self = shared_from_this()](beast::error_code = {}) {
    beast::error_code ignored;
    self->stream_.socket().shutdown(Socket::shutdown_send, ignored);
    self->stream_.expires_after(HttpServer::kRequestTime);
    if (!self->all_.stopping) self->wait_for_end();
  };
  if (!tls_) return half_close();
  stream_.expires_after(HttpServer::kRequestTime);
  tls_->async_shutdown(half_close);
}

// Closing the socket while bytes of the client are unread would reset the connection, and the client could lose the
// answer.
void HttpConnection::wait_for_end() {
  stream_.async_read_some(net::buffer(rest_), [self = shared_from_this()](beast::error_code error, size_t) {
    if (!error) self->wait_for_end();
  });
}

}  // namespace gnomon::daemon
