// Why a connection does not become a session, as its client and the operators are told.
#pragma once

#include <asio/ip/address.hpp>

#include <optional>
#include <string>

#include "daemon/metrics/metrics.h"
#include "daemon/scenes/scene_catalog.h"
#include "protocol/messages.h"
#include "scheduler/admission_control.h"

namespace gnomon::daemon {

// Who a connection says it is.
struct AdmissionClaim {
  std::string tenant = {};                // if empty, it named none, or did not get so far
  std::optional<SessionId> session = {};  // that it wants to resume
};

struct AdmissionRefusal {
  protocol::Refused message;
  Fault fault;
  std::optional<scheduler::Limit> limit = {};  // the exceeded limit; nullopt if none was exceeded
  bool departed = false;                       // the connection has ended, so that no refusal is sent
  std::string for_operators = {};              // logged in the place of the message's text
};

AdmissionRefusal refused(const protocol::Refused& message);
AdmissionRefusal refused(protocol::RefusalCode code, std::string text);
AdmissionRefusal refused(const scheduler::AdmissionRejection& rejection);
AdmissionRefusal without_permit(const protocol::Refused& message);  // of SessionLimits::take
AdmissionRefusal without_scene(const std::string& why, const std::string& scene, const SceneCatalog& catalog);
AdmissionRefusal departed();

// Counts the refusal and logs it with all that is known of who was refused. `tenant`: of a refusal with a limit.
void report(Metrics& metrics, const AdmissionRefusal& refusal, const AdmissionClaim& claim, TenantId tenant,
            const asio::ip::address& peer);

}  // namespace gnomon::daemon
