// What the net threads need to serve browsers, made once at the start.
#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/web/static_files.h"

namespace gnomon::daemon {

// Constant. Any thread.
struct WebService {
  explicit WebService(const WebConfig& config, const FleetConfig& fleet)
      : files(web::StaticFiles::of(web::embedded_files(), fleet.name)),
        hosts(config.hosts),
        patience(config.progress_timeout) {}

  const web::StaticFiles files;
  const std::vector<std::string> hosts;  // names by which browsers may reach us, beside those of the certificate
  const std::chrono::milliseconds patience;  // see web/progress.h
};

}  // namespace gnomon::daemon
