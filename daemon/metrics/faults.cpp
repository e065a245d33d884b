#include "daemon/metrics/faults.h"

#include <cassert>

namespace gnomon::daemon {
namespace {

using log::Level;
constexpr FaultKind kDatagram = FaultKind::datagram_rejected;
constexpr FaultKind kFrame = FaultKind::frame_dropped;
constexpr FaultKind kRefusal = FaultKind::refusal;
constexpr FaultKind kAdmin = FaultKind::admin_closed;
constexpr FaultKind kAsked = FaultKind::admin_refused;

// Faults that anybody can cause with one datagram are logged at debug, so that nobody can fill the log from outside.
constexpr std::array kTable{
    FaultRow{Fault::datagram_too_long, kDatagram, "too_long", Level::debug, "datagram too long"},
    FaultRow{Fault::datagram_header, kDatagram, "header", Level::debug, "datagram of another protocol"},
    FaultRow{Fault::datagram_session, kDatagram, "unknown_session", Level::debug, "datagram of no session"},
    FaultRow{Fault::datagram_replayed, kDatagram, "replayed", Level::debug, "datagram seen before or too old"},
    FaultRow{Fault::datagram_forged, kDatagram, "forged", Level::debug, "datagram forged or damaged"},
    FaultRow{Fault::datagram_kind, kDatagram, "kind", Level::debug,
             "datagram of a kind that a client may not send"},
    FaultRow{Fault::datagram_body, kDatagram, "body", Level::debug, "datagram malformed inside"},
    FaultRow{Fault::feedback_too_often, kDatagram, "feedback_rate", Level::debug,
             "more Feedback than a client needs"},
    FaultRow{Fault::feedback_invented, kDatagram, "invented_arrival", Level::warning,
             "client reports the arrival of a datagram that was never sent"},
    FaultRow{Fault::path_unproven, kDatagram, "path_unproven", Level::debug, "address that answered no challenge"},

    FaultRow{Fault::view_out_of_order, kFrame, "out_of_order", Level::debug, "view older than the newest"},
    FaultRow{Fault::view_queue_full, kFrame, "view_queue_full", Level::debug, "too many views waiting"},
    FaultRow{Fault::view_draining, kFrame, "draining", Level::debug, "view came while draining"},
    FaultRow{Fault::deadline_unreachable, kFrame, "deadline", Level::debug, "view that could not be ready in time"},
    FaultRow{Fault::submit_failed, kFrame, "submit_failed", Level::warning, "device refused a frame"},
    FaultRow{Fault::device_lost, kFrame, "device_lost", Level::warning, "frame lost with the device"},
    FaultRow{Fault::encode_failed, kFrame, "encode_failed", Level::warning, "frame could not be encoded"},
    FaultRow{Fault::session_gone, kFrame, "session_gone", Level::debug, "frame of a closed session"},
    FaultRow{Fault::send_queue_full, kFrame, "send_queue_full", Level::debug, "too many frames waiting to be sent"},
    FaultRow{Fault::socket_full, kFrame, "socket_full", Level::debug, "frame cut short: socket buffer full"},
    FaultRow{Fault::send_failed, kFrame, "send_failed", Level::debug, "frame cut short: network error"},
    FaultRow{Fault::link_too_slow, kFrame, "link_too_slow", Level::debug, "frame cut short: of no use any more"},

    FaultRow{Fault::refused_malformed, kRefusal, "malformed", Level::info, "refused"},
    FaultRow{Fault::refused_version, kRefusal, "version", Level::info, "refused"},
    FaultRow{Fault::refused_unknown_tenant, kRefusal, "unknown_tenant", Level::warning, "refused"},
    FaultRow{Fault::refused_bad_token, kRefusal, "bad_token", Level::warning, "refused"},
    FaultRow{Fault::refused_unknown_scene, kRefusal, "unknown_scene", Level::info, "refused"},
    FaultRow{Fault::refused_scene_unavailable, kRefusal, "scene_unavailable", Level::warning, "refused"},
    FaultRow{Fault::refused_bad_size, kRefusal, "bad_size", Level::info, "refused"},
    FaultRow{Fault::refused_too_many_sessions, kRefusal, "too_many_sessions", Level::warning, "refused"},
    FaultRow{Fault::refused_over_capacity, kRefusal, "over_capacity", Level::warning, "refused"},
    FaultRow{Fault::refused_unknown_pass, kRefusal, "unknown_pass", Level::info, "refused"},
    FaultRow{Fault::refused_draining, kRefusal, "draining", Level::info, "refused"},
    FaultRow{Fault::refused_internal, kRefusal, "internal", Level::error, "refused"},
    FaultRow{Fault::refused_unknown_session, kRefusal, "unknown_session", Level::info, "refused"},
    FaultRow{Fault::refused_kept_out, kRefusal, "kept_out", Level::info, "refused"},
    FaultRow{Fault::handshake_timeout, kRefusal, "handshake_timeout", Level::debug,
             "connection said no Hello in time"},
    FaultRow{Fault::handshake_abandoned, kRefusal, "abandoned", Level::debug, "connection closed before a session"},
    FaultRow{Fault::half_open_replaced, kRefusal, "half_open_replaced", Level::debug,
             "too many half-open connections"},
    FaultRow{Fault::web_stalled, kRefusal, "web_stalled", Level::debug,
             "browser asked for nothing, or did not take its answer"},
    FaultRow{Fault::webtransport_ticket, kRefusal, "webtransport_ticket", Level::debug,
             "WebTransport asked for without the ticket of a page of ours"},
    FaultRow{Fault::tls_version, kRefusal, "tls_version", Level::debug, "connection speaks no TLS 1.3"},
    FaultRow{Fault::tls_certificate, kRefusal, "tls_certificate", Level::warning, "client's certificate refused"},
    FaultRow{Fault::tls_distrusted, kRefusal, "tls_distrusted", Level::debug,
             "client refuses our certificate: it may have another pin or authority"},
    FaultRow{Fault::tls_failed, kRefusal, "tls", Level::debug, "connection speaks no TLS"},
    FaultRow{Fault::connection_rate, kRefusal, "connection_rate", Level::debug,
             "too many connections from one address"},
    FaultRow{Fault::web_rate, kRefusal, "web_rate", Level::debug, "browser's address asked for too much"},
    FaultRow{Fault::proxy_header, kRefusal, "proxy_header", Level::warning,
             "connection of one of server.proxies without a proper PROXY header"},
    FaultRow{Fault::proxy_unlisted, kRefusal, "proxy_unlisted", Level::warning,
             "connection with a PROXY header from an address that server.proxies does not name"},

    FaultRow{Fault::admin_timeout, kAdmin, "timeout", Level::debug, "admin connection asked for nothing in time"},
    FaultRow{Fault::admin_replaced, kAdmin, "replaced", Level::debug, "too many admin connections"},

    FaultRow{Fault::admin_host, kAsked, "host", Level::off, "admin request for another host"},
    FaultRow{Fault::admin_origin, kAsked, "origin", Level::off, "admin request of another server's page"},
    FaultRow{Fault::admin_no_token, kAsked, "no_token", Level::off, "admin request without the token"},
    FaultRow{Fault::admin_wrong_token, kAsked, "wrong_token", Level::off, "admin request with a wrong token"},
    FaultRow{Fault::admin_backoff, kAsked, "backoff", Level::off, "admin request too soon after wrong tokens"},
};

constexpr bool in_order() {
  for (size_t i = 0; i < kTable.size(); ++i) {
    if (static_cast<size_t>(kTable[i].fault) != i) return false;
  }
  return kTable.size() == static_cast<size_t>(Fault::admin_backoff) + 1;
}
static_assert(in_order(), "one row for each fault, in the enum's order");

}  // namespace

std::span<const FaultRow> fault_table() { return kTable; }

const FaultRow& row_of(Fault fault) { return kTable[static_cast<size_t>(fault)]; }

Fault fault_of(protocol::RefusalCode code) {
  using protocol::RefusalCode;
  switch (code) {
    case RefusalCode::malformed: return Fault::refused_malformed;
    case RefusalCode::version: return Fault::refused_version;
    case RefusalCode::unknown_tenant: return Fault::refused_unknown_tenant;
    case RefusalCode::bad_token: return Fault::refused_bad_token;
    case RefusalCode::unknown_scene: return Fault::refused_unknown_scene;
    case RefusalCode::scene_unavailable: return Fault::refused_scene_unavailable;
    case RefusalCode::bad_size: return Fault::refused_bad_size;
    case RefusalCode::too_many_sessions: return Fault::refused_too_many_sessions;
    case RefusalCode::over_capacity: return Fault::refused_over_capacity;
    case RefusalCode::unknown_pass: return Fault::refused_unknown_pass;
    case RefusalCode::draining: return Fault::refused_draining;
    case RefusalCode::internal: return Fault::refused_internal;
    case RefusalCode::unknown_session: return Fault::refused_unknown_session;
    case RefusalCode::kept_out: return Fault::refused_kept_out;
  }
  return Fault::refused_internal;
}

bool is_failed_authentication(Fault fault) {
  switch (fault) {
    case Fault::refused_unknown_tenant:
    case Fault::refused_bad_token:
    case Fault::tls_certificate: return true;
    default: return false;
  }
}

}  // namespace gnomon::daemon
