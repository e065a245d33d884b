// Everything that may go wrong at run time, in one table: its label in the metrics and its level in the log.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "common/log.h"
#include "protocol/messages.h"

namespace gnomon::daemon {

enum class Fault : uint8_t {
  // A datagram is rejected.
  datagram_too_long,
  datagram_header,
  datagram_session,
  datagram_replayed,
  datagram_forged,
  datagram_kind,
  datagram_body,
  feedback_too_often,
  feedback_invented,  // its session is closed
  path_unproven,
  // A view or a frame is dropped.
  view_out_of_order,
  view_queue_full,
  view_draining,
  deadline_unreachable,
  submit_failed,
  device_lost,
  encode_failed,
  session_gone,
  send_queue_full,
  socket_full,
  send_failed,
  link_too_slow,
  // A connection is refused a session.
  refused_malformed,
  refused_version,
  refused_unknown_tenant,
  refused_bad_token,
  refused_unknown_scene,
  refused_scene_unavailable,
  refused_bad_size,
  refused_too_many_sessions,
  refused_over_capacity,
  refused_unknown_pass,
  refused_draining,
  refused_internal,
  refused_unknown_session,
  refused_kept_out,
  handshake_timeout,
  handshake_abandoned,
  half_open_replaced,
  web_stalled,
  webtransport_ticket,
  tls_version,
  tls_certificate,
  tls_distrusted,
  tls_failed,
  connection_rate,
  web_rate,
  proxy_header,
  proxy_unlisted,
  // A connection to the admin server is closed before it has asked for anything.
  admin_timeout,
  admin_replaced,
  // A request to the admin server is refused over TCP. Lines in the audit log say who asked for what.
  admin_host,
  admin_origin,
  admin_no_token,
  admin_wrong_token,
  admin_backoff,
};

enum class FaultKind : uint8_t { datagram_rejected, frame_dropped, refusal, admin_closed, admin_refused };

struct FaultRow {
  Fault fault;
  FaultKind kind;
  const char* label;  // of the metric; unique within its kind
  log::Level level;
  const char* event;  // of the log line
};

// In the enum's order, one row each.
std::span<const FaultRow> fault_table();
const FaultRow& row_of(Fault fault);

Fault fault_of(protocol::RefusalCode code);

// Whether somebody failed to prove who they are, which belongs into the audit log too.
bool is_failed_authentication(Fault fault);

}  // namespace gnomon::daemon
