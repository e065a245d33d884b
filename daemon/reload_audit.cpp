#include "daemon/reload_audit.h"

#include "common/log.h"

namespace gnomon::daemon {

namespace {

std::string listed(const std::vector<std::string>& changes) {
  std::string all;
  for (const std::string& change : changes) all += (all.empty() ? "" : ", ") + change;
  return all;
}

}  // namespace

std::vector<std::string> ReloadAudit::applied(const Config& next, const Kept& kept, const protocol::Pin& old_pin,
                                              const protocol::Pin& pin, const char* asked_by) {
  ConfigValues values = next.values;
  for (const std::string& key : kept.keys) keep_values(values, values_, key);
  std::vector<std::string> changes = changes_between(values_, values);
  if (pin != old_pin) {
    changes.push_back("certificate: " + protocol::to_string(old_pin) + " -> " + protocol::to_string(pin));
  }
  values_ = std::move(values);
  file_ = next.log.audit_file;
  if (kept.why.empty()) {
    log::audit("configuration", {{"asked_by", asked_by}, {"result", "done"}, {"changes", listed(changes)}});
  } else {
    log::audit("configuration",
               {{"asked_by", asked_by}, {"result", "in part"}, {"changes", listed(changes)}, {"reason", kept.why}});
  }
  return changes;
}

// A file that was rotated is opened anew also if the configuration has a mistake.
void ReloadAudit::refused(const std::string& why, const char* asked_by) const {
  if (auto opened = log::set_audit_file(file_); !opened) {
    log::error("audit log not opened anew", {{"why", opened.error().message}});
  }
  log::audit("configuration", {{"asked_by", asked_by}, {"result", "refused"}, {"reason", why}});
}

}  // namespace gnomon::daemon
