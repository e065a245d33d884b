#include "daemon/net/control_sender.h"

namespace gnomon::daemon {

std::optional<Fault> send_over_control(Session& session, ControlStream& stream, TimePoint now) {
  LinkSender& link = session.link();
  std::optional<Fault> fault;
  while (const auto out = link.next(now)) {
    session.omit_number();
    protocol::Data data{out->kind, session.seal().skip(), {out->body.begin(), out->body.end()}};
    link.sent(data.sequence, protocol::Seal::sealed_size(data.body.size()), now);
    if (out->kind == protocol::DatagramKind::probe) continue;  // TCP takes any length: there is no MTU to probe
    if (!stream.send_data(data)) fault = Fault::socket_full;
  }
  return fault;
}

}  // namespace gnomon::daemon
