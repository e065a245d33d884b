// The lines that reloads have in the audit log, and the log's file, which each of them opens anew.
//
// The main thread.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "daemon/config/config.h"
#include "protocol/pin.h"

namespace gnomon::daemon {

class ReloadAudit {
 public:
  explicit ReloadAudit(const Config& running) : values_(running.values), file_(running.log.audit_file) {}

  // What was not applied.
  struct Kept {
    std::vector<std::string> keys;  // those that have their values of before
    std::string why;                // empty if all was applied
  };
  // `next` is in force but for what was kept. The pins are those of the certificate before and after. `asked_by`: "SIGHUP",
  // "operator". Returns the changes, one for each key.
  std::vector<std::string> applied(const Config& next, const Kept& kept, const protocol::Pin& old_pin,
                                   const protocol::Pin& pin, const char* asked_by);
  void refused(const std::string& why, const char* asked_by) const;

 private:
  ConfigValues values_;  // of the configuration that is in force
  std::filesystem::path file_;
};

}  // namespace gnomon::daemon
