#include "daemon/admin/http_tls.h"

#include "daemon/admin/http_server.h"
#include "daemon/security/private_file.h"

namespace gnomon::daemon {

namespace ssl = boost::asio::ssl;

Result<std::shared_ptr<HttpTls>> open_http_tls(const AdminTlsConfig& files) {
  if (auto checked = check_private("admin.tls.key", files.key); !checked) return checked.error();
  auto tls = std::make_shared<HttpTls>();
  ssl::context& context = tls->context;
  boost::system::error_code error;
  context.set_options(ssl::context::no_tlsv1 | ssl::context::no_tlsv1_1 | ssl::context::no_tlsv1_2, error);
  context.use_certificate_chain_file(files.certificate.string(), error);
  if (error) return Error{"admin.tls.certificate: " + files.certificate.string() + ": " + error.message()};
  context.use_private_key_file(files.key.string(), ssl::context::pem, error);
  if (error) return Error{"admin.tls.key: " + files.key.string() + ": " + error.message()};
  return tls;
}

}  // namespace gnomon::daemon
