// TLS of the admin server, which it speaks off loopback. Included by sources with Boost.Asio only.
#pragma once

#include <boost/asio/ssl/context.hpp>

namespace gnomon::daemon {

struct HttpTls {
  boost::asio::ssl::context context{boost::asio::ssl::context::tls_server};
};

}  // namespace gnomon::daemon
