// The handlers of the admin server's pages and actions.
#pragma once

#include <atomic>
#include <future>
#include <string>

#include "daemon/admin/admin.h"
#include "daemon/admin/operated_parts.h"

namespace gnomon::daemon {

// Called on the admin server's threads, several at a time. Outlives that server.
class Operations {
 public:
  explicit Operations(OperatedParts parts);

  Admin::Pages pages();
  Admin::Actions actions();

 private:
  Page kick(const std::string& session, const std::string& body);
  Page set_draining(bool draining);
  Page begin_stop();
  Page drain_device(const std::string& number, bool drained);
  Page load_scene(const std::string& name);
  Page unload_scene(const std::string& name);
  Page await(std::future<Result<std::string>> done);
  Page reload_page();
  Page readiness() const;
  Page change_light(const std::string& scene, const std::string& light, const std::string& body);
  Page take_lights(const std::string& body);

  OperatedParts parts_;
  std::atomic<bool> loading_{false};  // an operator's request to load a scene is in progress
};

}  // namespace gnomon::daemon
