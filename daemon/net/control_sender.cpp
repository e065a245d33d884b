#include "daemon/net/control_sender.h"

namespace gnomon::daemon {

bool send_over_control(Session& session, ControlStream& stream, TimePoint now) {
  LinkSender& link = session.link();
  while (stream.has_room()) {
    const auto out = link.next(now);
    if (!out) return true;
    session.omit_number();
    const protocol::Data data{out->kind, session.seal().skip(), {out->body.begin(), out->body.end()}};
    link.sent(data.sequence, protocol::Seal::sealed_size(data.body.size()), now);
    if (out->kind == protocol::DatagramKind::probe) continue;  // TCP takes any length: there is no MTU to probe
    stream.send_data(data);
  }
  link.next(now);  // is not sent, but what has lost its use is dropped, so that what waits is bounded
  return false;
}

}  // namespace gnomon::daemon
