// One connection to the admin server: one request, one answer. Included by sources with Boost.Asio only.
#pragma once

#include <array>
#include <boost/asio/generic/stream_protocol.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ssl/stream.hpp>
#include <boost/asio/thread_pool.hpp>
#include <boost/beast/core/basic_stream.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http.hpp>
#include <list>
#include <memory>
#include <optional>

#include "daemon/admin/http_server.h"

namespace gnomon::daemon {

class HttpConnection;

// What the connections of a server have in common. The thread of `io` alone uses it, but for what is constant.
struct HttpConnections {
  HttpConnections(HttpServer::Answers to_answer, Metrics& counts)
      : answers(std::move(to_answer)), metrics(counts) {}

  static constexpr size_t kThreads = 2;  // of each pool: one pool answers GET, the other POST

  const HttpServer::Answers answers;
  Metrics& metrics;
  std::list<HttpConnection*> open;  // oldest first
  size_t answering = 0;
  bool stopping = false;
  boost::asio::io_context io{1};
  boost::asio::thread_pool looking{kThreads}, changing{kThreads};
};

// Kept alive by its own pending operations.
class HttpConnection : public std::enable_shared_from_this<HttpConnection> {
 public:
  using Socket = boost::asio::generic::stream_protocol::socket;

  // `tls`: nullptr if the connection is not encrypted.
  HttpConnection(Socket socket, Caller caller, std::shared_ptr<HttpTls> tls, HttpConnections& all);
  ~HttpConnection();

  enum class State { asking, answering, writing, leaving };
  State state() const { return state_; }

  void begin();
  void close();

 private:
  using Stream = boost::beast::basic_stream<boost::asio::generic::stream_protocol>;

  template <class Do>
  void on_stream(Do&& operation);
  void read();
  void on_request(boost::beast::error_code error);
  void answer(boost::asio::thread_pool& pool, const HttpServer::Answer& make_page, HttpRequest request);
  // An answer on its way from a pool's thread to that of `io`.
  struct Answered {
    std::shared_ptr<HttpConnection> connection;
    Page page;
  };
  static void finish(std::unique_ptr<Answered> answered);
  void write(Page page);
  void leave();
  void leave_list();
  void wait_for_end();

  const std::shared_ptr<HttpTls> context_;
  Stream stream_;
  std::optional<boost::asio::ssl::stream<Stream&>> tls_;
  const Caller caller_;
  HttpConnections& all_;
  std::optional<std::list<HttpConnection*>::iterator> place_;  // nullopt if it is being closed
  State state_ = State::asking;
  bool head_ = false;
  boost::beast::flat_buffer buffer_;
  boost::beast::http::request_parser<boost::beast::http::string_body> parser_;
  boost::beast::http::response<boost::beast::http::string_body> response_;
  std::array<char, 1024> rest_;
};

}  // namespace gnomon::daemon
