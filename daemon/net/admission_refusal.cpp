#include "daemon/net/admission_refusal.h"

#include <utility>

#include "daemon/net/words_for_clients.h"
#include "daemon/session/handshake.h"

namespace gnomon::daemon {
namespace {

using protocol::RefusalCode;

constexpr size_t kMostOfName = 80;  // of a tenant's that a stranger made up, in the log

protocol::Refused refusal_of(const scheduler::AdmissionRejection& rejection) {
  const bool size = rejection.limit == scheduler::Limit::size;
  std::string text("beyond the limit of ");
  text.append(to_string(rejection.limit));
  protocol::Refused refused = refusal(size ? RefusalCode::bad_size : RefusalCode::over_capacity, text);
  refused.fit_width = static_cast<uint16_t>(rejection.fit_width);
  refused.fit_height = static_cast<uint16_t>(rejection.fit_height);
  refused.fit_rate_hz = static_cast<float>(rejection.fit_rate_hz);
  return refused;
}

}  // namespace

AdmissionRefusal refused(const protocol::Refused& message) { return {message, fault_of(message.code)}; }

AdmissionRefusal refused(RefusalCode code, std::string text) { return refused(refusal(code, std::move(text))); }

AdmissionRefusal refused(const scheduler::AdmissionRejection& rejection) {
  const protocol::Refused message = refusal_of(rejection);
  return {message, fault_of(message.code), rejection.limit};
}

AdmissionRefusal without_permit(const protocol::Refused& message) {
  return {message, fault_of(message.code), scheduler::Limit::sessions};
}

AdmissionRefusal without_scene(const std::string& why, const std::string& scene, const SceneCatalog& catalog) {
  AdmissionRefusal refusal = refused(RefusalCode::scene_unavailable, without_folder(why, scene, catalog));
  refusal.for_operators = why;
  return refusal;
}

AdmissionRefusal departed() { return {.message = {}, .fault = Fault::handshake_abandoned, .departed = true}; }

void report(Metrics& metrics, const AdmissionRefusal& refusal, const AdmissionClaim& claim, TenantId tenant_id,
            const asio::ip::address& peer) {
  if (refusal.limit) metrics.refused(tenant_id, to_string(*refusal.limit));
  const log::Field reason("reason", row_of(refusal.fault).label);
  const log::Field text("text", refusal.for_operators.empty() ? refusal.message.text : refusal.for_operators);
  const log::Field tenant("tenant", claim.tenant.substr(0, kMostOfName));
  const log::Field address("address", peer.to_string());
  if (!claim.session) return metrics.report(refusal.fault, {reason, text, tenant, address});
  metrics.report(refusal.fault, {reason, text, tenant, {"session", claim.session->value}, address});
}

}  // namespace gnomon::daemon
