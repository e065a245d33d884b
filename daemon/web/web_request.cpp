#include "daemon/web/web_request.h"

#include <algorithm>
#include <boost/asio/buffer.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/rfc7230.hpp>
#include <iterator>
#include <string_view>

namespace gnomon::daemon::web {
namespace {

namespace http = boost::beast::http;
using Parser = http::request_parser<http::empty_body>;
using Fields = http::request<http::empty_body>;

std::string text(boost::beast::string_view view) { return {view.data(), view.size()}; }

Request::Method method_of(http::verb verb) {
  switch (verb) {
    case http::verb::get: return Request::Method::get;
    case http::verb::head: return Request::Method::head;
    default: return Request::Method::other;
  }
}

bool names(boost::beast::string_view list, boost::beast::string_view token) {
  return http::token_list(list).exists(token);
}

size_t count(const Fields& fields, http::field name) {
  const auto range = fields.equal_range(name);
  return static_cast<size_t>(std::distance(range.first, range.second));
}

Request to_request(const Fields& from) {
  Request request;
  request.method = method_of(from.method());
  request.target = text(from.target());
  request.target.resize(std::min(request.target.size(), request.target.find('?')));
  request.keep_alive = from.keep_alive();
  request.host = text(from[http::field::host]);
  request.origin = text(from[http::field::origin]);
  request.authorization = text(from[http::field::authorization]);
  request.tenant = text(from["Gnomon-Tenant"]);
  request.if_none_match = text(from[http::field::if_none_match]);
  request.accept_encoding = text(from[http::field::accept_encoding]);
  request.upgrade =
      names(from[http::field::connection], "upgrade") && names(from[http::field::upgrade], "websocket");
  request.websocket_key = text(from[http::field::sec_websocket_key]);
  request.websocket_version = text(from[http::field::sec_websocket_version]);
  request.websocket_protocol = text(from[http::field::sec_websocket_protocol]);
  return request;
}

BadRequest complaint(const boost::beast::error_code& error) {
  if (error == http::error::header_limit || error == http::error::buffer_overflow) {
    return {431, "the header is too long"};
  }
  if (error == http::error::unexpected_body || error == http::error::body_limit) {
    return {413, "requests have no bodies here"};
  }
  return {400, "no HTTP request"};
}

}  // namespace

void RequestReader::feed(std::span<const uint8_t> bytes) {
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
}

// The parser begins anew with each look, and a stranger may send byte by byte: so a header is looked at when it is
// complete, and before, as it may be none, only when it has doubled.
bool RequestReader::is_worth_a_look() {
  constexpr std::string_view kEnd = "\r\n\r\n";
  const size_t from = searched_ < kEnd.size() ? 0 : searched_ - kEnd.size();
  const auto found =
      std::search(buffer_.begin() + static_cast<ptrdiff_t>(from), buffer_.end(), kEnd.begin(), kEnd.end());
  searched_ = buffer_.size();
  if (found == buffer_.end() && buffer_.size() < 2 * looked_at_ && buffer_.size() < kMaxHeader) return false;
  looked_at_ = buffer_.size();
  return true;
}

std::variant<std::optional<Request>, BadRequest> RequestReader::next() {
  if (buffer_.empty() || !is_worth_a_look()) return std::nullopt;
  Parser parser;
  parser.header_limit(kMaxHeader);
  parser.body_limit(0);
  boost::beast::error_code error;
  const size_t used = parser.put(boost::asio::buffer(buffer_), error);
  if (error == http::error::need_more && buffer_.size() < kMaxHeader) return std::nullopt;
  if (error == http::error::need_more) return BadRequest{431, "the header is too long"};
  if (error) return complaint(error);
  if (!parser.is_done()) return BadRequest{413, "requests have no bodies here"};
  // Two of them, or one that is missing, would leave open whom the request is for (RFC 9112, 3.2).
  if (parser.get().version() != 11) return BadRequest{505, "HTTP/1.1 is spoken here"};
  if (count(parser.get(), http::field::host) != 1) return BadRequest{400, "a request names one Host"};
  Request request = to_request(parser.get());
  buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<ptrdiff_t>(used));
  searched_ = looked_at_ = 0;
  return std::optional(std::move(request));
}

}  // namespace gnomon::daemon::web
