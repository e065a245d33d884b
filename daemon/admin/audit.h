// The admin server's lines in the audit log. Any thread.
#pragma once

#include <string>

#include "daemon/admin/http_message.h"
#include "daemon/metrics/faults.h"

namespace gnomon::daemon {

// An operator's action on `target` ("12", "box 0"; empty for the daemon itself), and the answer to it.
void audit_action(const HttpRequest& request, const char* action, const std::string& target, const Page& answer);

// A process that came through the socket and is no operator.
void audit_no_operator(const HttpRequest& request, const char* action, const std::string& target);

void audit_refused_over_tcp(const HttpRequest& request, Fault fault);

}  // namespace gnomon::daemon
