#include "daemon/ctl/http_exchange.h"

#include <boost/asio/generic/stream_protocol.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/ssl.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <optional>

namespace gnomon::ctl {
namespace {

namespace net = boost::asio;
namespace beast = boost::beast;
namespace http = boost::beast::http;
using Kind = AdminAddress::Kind;
using ErrorCode = beast::error_code;
using namespace std::chrono_literals;

constexpr std::chrono::milliseconds kConnectTime = 3s;
constexpr uint64_t kMostBytes = 256 << 20;  // of an answer

// Names of scenes may have any byte in them.
std::string percent_encoded(const std::string& path) {
  constexpr std::string_view kPlain = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-._~/",
                             kDigits = "0123456789ABCDEF";
  std::string encoded;
  for (const char c : path) {
    const auto byte = static_cast<unsigned char>(c);
    if (kPlain.find(c) != std::string_view::npos) {
      encoded += c;
    } else {
      encoded.append({'%', kDigits[byte >> 4], kDigits[byte & 15]});
    }
  }
  return encoded;
}

// Runs one operation at a time and waits for its end, or cuts it off when its time is over.
class Exchange {
 public:
  Result<HttpAnswer> run(const AdminAddress& address, const HttpAsked& asked, const HttpTrust& trust,
                         std::chrono::milliseconds longest) {
    const ErrorCode connected =
        address.kind == Kind::unix_socket ? connect_locally(address) : connect_over_tcp(address);
    if (connected) return Error{connected.message()};
    if (address.kind != Kind::https) return talk(socket_, address, asked, longest);
    const ErrorCode secured = secure(address, trust);
    if (secured) return Error{"no TLS with it: " + secured.message()};
    return talk(*tls_, address, asked, longest);
  }

 private:
  using Socket = net::generic::stream_protocol::socket;

  // `begin` starts an operation, given the function that it calls at its end.
  template <class Begin>
  ErrorCode finish(Begin&& begin, std::chrono::milliseconds longest) {
    ErrorCode result = net::error::timed_out;
    begin([&result](ErrorCode error, auto&&...) { result = error; });
    io_.restart();
    io_.run_for(longest);
    if (io_.stopped()) return result;
    ErrorCode ignored;
    socket_.close(ignored);
    io_.run();
    return net::error::timed_out;
  }

  ErrorCode connect_locally(const AdminAddress& address) {
    net::local::stream_protocol::endpoint endpoint;
    try {
      endpoint = address.host;
    } catch (const boost::system::system_error& too_long) {
      return too_long.code();
    }
    return finish([&](auto done) { socket_.async_connect(endpoint, done); }, kConnectTime);
  }

  ErrorCode connect_over_tcp(const AdminAddress& address) {
    net::ip::tcp::resolver resolver(io_);
    ErrorCode error;
    const auto found = resolver.resolve(address.host, address.port, error);
    if (error) return error;
    for (const auto& entry : found) {
      ErrorCode ignored;
      socket_.close(ignored);
      error = finish([&](auto done) { socket_.async_connect(entry.endpoint(), done); }, kConnectTime);
      if (!error) break;
    }
    return error;
  }

  ErrorCode secure(const AdminAddress& address, const HttpTrust& trust) {
    ErrorCode error;
    if (trust.authority.empty()) {
      context_.set_default_verify_paths(error);
    } else {
      context_.load_verify_file(trust.authority, error);
    }
    if (error) return error;
    tls_.emplace(socket_, context_);
    tls_->set_verify_mode(net::ssl::verify_peer, error);
    const std::string& name = trust.name.empty() ? address.host : trust.name;
    tls_->set_verify_callback(net::ssl::rfc2818_verification(name), error);
    if (error) return error;
    return finish([&](auto done) { tls_->async_handshake(net::ssl::stream_base::client, done); }, kConnectTime);
  }

  template <class Stream>
  Result<HttpAnswer> talk(Stream& stream, const AdminAddress& address, const HttpAsked& asked,
                          std::chrono::milliseconds longest) {
    http::request<http::string_body> request(asked.changes ? http::verb::post : http::verb::get,
                                             percent_encoded(asked.path), 11);
    const bool v6 = address.host.find(':') != std::string::npos;
    const std::string name = v6 ? "[" + address.host + "]" : address.host;
    request.set(http::field::host, address.kind == Kind::unix_socket ? "localhost" : name + ":" + address.port);
    if (!asked.token.empty()) request.set(http::field::authorization, "Bearer " + asked.token);
    if (asked.changes) request.set(http::field::content_type, "application/json");
    request.body() = asked.body;
    request.prepare_payload();
    http::response_parser<http::string_body> parser;
    parser.body_limit(kMostBytes);
    beast::flat_buffer buffer;
    ErrorCode error = finish([&](auto done) { http::async_write(stream, request, done); }, longest);
    if (!error) error = finish([&](auto done) { http::async_read(stream, buffer, parser, done); }, longest);
    if (error) return Error{error.message()};
    return HttpAnswer{static_cast<int>(parser.get().result_int()), parser.get().body()};
  }

  net::io_context io_{1};
  Socket socket_{io_};
  net::ssl::context context_{net::ssl::context::tls_client};
  std::optional<net::ssl::stream<Socket&>> tls_;
};

}  // namespace

std::string AdminAddress::text() const {
  if (kind == Kind::unix_socket) return "unix:" + host;
  const bool v6 = host.find(':') != std::string::npos;
  return (kind == Kind::https ? "https://" : "http://") + (v6 ? "[" + host + "]" : host) + ":" + port;
}

Result<AdminAddress> parse_admin_address(const std::string& text) {
  const Error wrong{text + " is no address; allowed: unix:PATH, http://HOST:PORT, https://HOST:PORT"};
  constexpr std::string_view kUnix = "unix:", kHttp = "http://", kHttps = "https://";
  if (text.starts_with(kUnix)) {
    return text.size() > kUnix.size() ? Result<AdminAddress>({Kind::unix_socket, text.substr(kUnix.size())})
                                      : wrong;
  }
  const bool secure = text.starts_with(kHttps);
  if (!secure && !text.starts_with(kHttp)) return wrong;
  std::string rest = text.substr(secure ? kHttps.size() : kHttp.size());
  if (rest.ends_with('/')) rest.pop_back();
  const bool bracketed = rest.starts_with('[');
  const size_t colon = bracketed ? rest.find("]:") : rest.find(':');
  if (colon == std::string::npos || colon == 0 || rest.find('/') != std::string::npos) return wrong;
  const std::string host = bracketed ? rest.substr(1, colon - 1) : rest.substr(0, colon);
  const std::string port = rest.substr(colon + (bracketed ? 2 : 1));
  if (host.empty() || port.empty() || port.find_first_not_of("0123456789") != std::string::npos) return wrong;
  return AdminAddress{secure ? Kind::https : Kind::http, host, port};
}

Result<HttpAnswer> exchange(const AdminAddress& address, const HttpAsked& asked, const HttpTrust& trust,
                            std::chrono::milliseconds longest) {
  return Exchange().run(address, asked, trust, longest);
}

}  // namespace gnomon::ctl
