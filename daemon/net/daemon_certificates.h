// The certificate that the daemon shows and what it accepts of its clients': read at the start and at reloads, published
// for new connections, and watched for the day on which the first of them expires.
#pragma once

#include <chrono>
#include <vector>

#include "daemon/metrics/metrics.h"
#include "daemon/net/tls.h"
#include "daemon/security/expiry_reminder.h"

namespace gnomon::daemon {

// The main thread, but for what is published.
class DaemonCertificates {
 public:
  explicit DaemonCertificates(Metrics& metrics) : metrics_(metrics) {}

  Result<void> open(const ServerConfig& config, bool browsers);
  // Returns what stays as it was, and why.
  std::vector<Error> reopen(const ServerConfig& config);

  // Logs a reminder of the certificate that expires first, if it is time for one. Called now and then.
  void remind(std::chrono::sys_seconds now);

  const PublishedTls& published() const { return tls_; }

 private:
  void publish(std::shared_ptr<Tls> tls);

  Metrics& metrics_;
  PublishedTls tls_;
  ExpiryReminder reminder_;
};

}  // namespace gnomon::daemon
