// From an accepted connection to an open session: a new one, or one that lost its connection before.
//
//   identify or reclaim -> take a permit -> await the devices -> fetch the scene -> book -> find room -> open
//
// The first message of each connection starts one coroutine on the net thread's event loop. While it waits for another
// thread, its connection stays among the pending ones, as an applicant; if the connection ends meanwhile, so does the
// coroutine, and gives back what it has taken.
#pragma once

#include <asio/awaitable.hpp>
#include <asio/io_context.hpp>
#include <asio/ip/tcp.hpp>

#include <memory>
#include <optional>
#include <stop_token>
#include <string>

#include "common/token_buckets.h"
#include "daemon/net/admission_refusal.h"
#include "daemon/net/net_shared.h"
#include "daemon/net/pending_connections.h"
#include "daemon/net/session_control.h"
#include "daemon/session/client_network.h"
#include "daemon/session/session.h"

namespace gnomon::daemon {

// Belongs to the net thread. Outlived by everything it refers to.
class Admission {
 public:
  // `data_port`: where the clients of this net thread send their datagrams.
  Admission(const NetShared& shared, uint16_t data_port, asio::io_context& io, SessionControl& control,
            PendingConnections& pending);

  // The socket's executor is that of `io`. `client`: who is at its other end, or at that of a proxy.
  void on_accept(asio::ip::tcp::socket socket, const asio::ip::address& client);
  void close_overdue(TimePoint now);  // connections that have not become a session in time

 private:
  using StreamPtr = std::shared_ptr<ControlStream>;

  using Claim = AdmissionClaim;
  using Refusal = AdmissionRefusal;
  using Verdict = std::optional<Refusal>;  // nullopt if the step was taken

  // What a connection has gathered on its way to a session.
  struct Applicant {
    StreamPtr stream;
    Claim claim = {};
    std::stop_source departure = {};  // stopped when the connection ends while the applicant waits
    SessionGrant grant = {};
    StoredSession stored = {};  // the session that is resumed; empty if a new one is opened
    std::optional<SessionPermit> permit = {};
    SceneForUse scene = {};
  };

  asio::awaitable<void> admit(StreamPtr stream, protocol::Message first);
  asio::awaitable<Verdict> take_steps(Applicant& applicant, const protocol::Message& first);
  Verdict identify(Applicant& applicant, const protocol::Hello& hello) const;
  asio::awaitable<Verdict> reclaim(Applicant& applicant, const protocol::Resume& resume);
  Verdict take_permit(Applicant& applicant);
  asio::awaitable<Verdict> await_start(const Applicant& applicant);
  asio::awaitable<Verdict> fetch_scene(Applicant& applicant);
  Verdict book(Applicant& applicant) const;
  asio::awaitable<Verdict> find_room(const Applicant& applicant);
  Verdict open(Applicant& applicant);

  void on_first_message(const StreamPtr& stream, Result<protocol::Message> message);
  template <typename OnMessage>
  void listen(const StreamPtr& stream, OnMessage on_message, std::stop_source departure);
  void keep_pending(const Applicant& applicant);
  asio::awaitable<void> tell_what_it_waits_for(StreamPtr stream, std::string scene);
  void on_bye(const StreamPtr& stream);
  bool has_departed(const Applicant& applicant) const { return !pending_.is_waiting(applicant.stream.get()); }
  Result<std::unique_ptr<protocol::Seal>> make_seal(Applicant& applicant, SessionId id) const;
  void refuse(const StreamPtr& stream, const Refusal& refusal, const Claim& claim, TenantId tenant = {});

  const NetShared& shared_;
  const uint16_t data_port_;
  asio::io_context& io_;
  SessionControl& control_;
  PendingConnections& pending_;
  TokenBuckets<ClientNetwork> web_requests_;
};

}  // namespace gnomon::daemon
