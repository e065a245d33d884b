#include "daemon/admin/audit.h"

#include "common/log.h"
#include "daemon/admin/operators.h"

namespace gnomon::daemon {
namespace {

constexpr size_t kMostText = 300;  // bytes of what a caller has sent

std::string operator_of(const Caller& caller) {
  return caller.process ? account_name(caller.process->uid) : "token";
}

std::string address_of(const Caller& caller) { return caller.process ? "socket" : caller.address; }

std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')).substr(0, kMostText); }

// "{}" says nothing beside the action.
std::string details_of(const HttpRequest& request) {
  return request.body.size() <= 2 ? "" : request.body.substr(0, kMostText);
}

}  // namespace

void audit_action(const HttpRequest& request, const char* action, const std::string& target, const Page& answer) {
  const bool done = answer.status / 100 == 2;
  log::audit("action", {{"operator", operator_of(request.caller)},
                        {"address", address_of(request.caller)},
                        {"action", action},
                        {"target", target},
                        {"details", details_of(request)},
                        {"result", done ? "done" : "refused"},
                        {"reason", done ? "" : first_line(answer.body)}});
}

void audit_no_operator(const HttpRequest& request, const char* action, const std::string& target) {
  log::audit_refusal("admin request of no operator", {{"operator", operator_of(request.caller)},
                                                      {"address", address_of(request.caller)},
                                                      {"action", action},
                                                      {"target", target},
                                                      {"result", "refused"},
                                                      {"reason", "no_operator"}});
}

// Each reason is an event of its own, so that many of one do not leave out those of another.
void audit_refused_over_tcp(const HttpRequest& request, Fault fault) {
  const FaultRow& row = row_of(fault);
  log::audit_refusal(row.event, {{"operator", "unknown"},
                                 {"address", request.caller.address},
                                 {"action", request.changes ? "POST" : "GET"},
                                 {"target", request.path.substr(0, kMostText)},
                                 {"result", "refused"},
                                 {"reason", row.label}});
}

}  // namespace gnomon::daemon
