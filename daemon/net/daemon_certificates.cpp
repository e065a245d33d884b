#include "daemon/net/daemon_certificates.h"

#include "common/log.h"
#include "common/wall_clock.h"

namespace gnomon::daemon {

Result<void> DaemonCertificates::open(const ServerConfig& config, bool browsers) {
  auto tls = open_tls(config, browsers);
  if (!tls) return tls.error();
  if (const auto why = out_of_date(config.tls.certificate, **tls, wall_now()); !why.empty()) {
    log::error("no client will connect", {{"why", why}});
  }
  publish(std::move(*tls));
  return {};
}

std::vector<Error> DaemonCertificates::reopen(const ServerConfig& config) {
  ReopenedTls reopened = reopen_tls(config, **tls_.get());
  publish(std::move(reopened.tls));
  remind(wall_now());
  return std::move(reopened.kept);
}

void DaemonCertificates::publish(std::shared_ptr<Tls> tls) {
  metrics_.operation().certificate_expires(first_expiry(*tls).at);
  tls_.publish(std::move(tls));
}

void DaemonCertificates::remind(std::chrono::sys_seconds now) {
  const FirstExpiry first = first_expiry(**tls_.get());
  const auto left = reminder_.due(first.at, now);
  if (!left) return;
  const int64_t days = left->count();
  if (days < 0) return log::error("a certificate has expired", {{"key", first.key}, {"days_left", days}});
  log::warning("a certificate expires soon", {{"key", first.key}, {"days_left", days}});
}

}  // namespace gnomon::daemon
