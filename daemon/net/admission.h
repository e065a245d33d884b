// From an accepted connection to an open session: a new one, or one that lost its connection before.
//
//   identify or reclaim -> check -> seat -> fetch the scene -> book -> find room -> open
//
// Each connection is one coroutine on the net thread's event loop. Where it waits for another thread, its connection
// stays in the lobby; should that end meanwhile, the coroutine ends at its next step.
#pragma once

#include <asio/awaitable.hpp>
#include <asio/io_context.hpp>
#include <asio/ip/tcp.hpp>

#include <memory>
#include <optional>

#include "daemon/net/lobby.h"
#include "daemon/net/net_shared.h"
#include "daemon/net/session_control.h"
#include "daemon/session/session.h"

namespace gnomon::daemon {

// The net thread's. Outlived by what it refers to.
class Admission {
 public:
  // `data_port`: where the clients of this net thread send their datagrams.
  Admission(const NetShared& shared, uint16_t data_port, asio::io_context& io, SessionControl& control,
            Lobby& lobby);

  void on_accept(asio::ip::tcp::socket socket);  // its executor is that of `io`
  void close_overdue(TimePoint now);             // connections that did not become a session in time

 private:
  using StreamPtr = std::shared_ptr<ControlStream>;

  // What a connection has gathered on its way to a session.
  struct Applicant {
    StreamPtr stream;
    SessionGrant grant = {};
    KeptSession kept = {};  // the session that it resumes; empty if it opens a new one
    std::optional<Seat> seat = {};
    SceneForUse scene = {};
  };

  // Why a connection becomes no session.
  struct Refusal {
    protocol::Refused message;
    Fault fault;
    std::optional<scheduler::Limit> limit = {};  // of its tenant, if that was exceeded
    bool departed = false;                       // the connection has ended: nobody is refused
  };
  using Verdict = std::optional<Refusal>;  // nullopt if the step was taken

  asio::awaitable<void> admit(StreamPtr stream, protocol::Message first);
  asio::awaitable<Verdict> take_steps(Applicant& applicant, const protocol::Message& first);
  Verdict identify(Applicant& applicant, const protocol::Hello& hello) const;
  asio::awaitable<Verdict> reclaim(Applicant& applicant, const protocol::Resume& resume);
  Verdict seat(Applicant& applicant);
  asio::awaitable<Verdict> fetch_scene(Applicant& applicant);
  Verdict book(Applicant& applicant) const;
  asio::awaitable<Verdict> find_room(const Applicant& applicant);
  Verdict open(Applicant& applicant);

  void on_first_message(const StreamPtr& stream, Result<protocol::Message> message);
  template <typename OnMessage>
  void listen(const StreamPtr& stream, OnMessage on_message);
  void hold(const StreamPtr& stream);
  bool has_departed(const Applicant& applicant) const { return !lobby_.hosts(applicant.stream.get()); }
  Result<std::unique_ptr<protocol::Seal>> make_seal(Applicant& applicant, SessionId id) const;
  void send_welcome(ControlStream& stream, const Session& session, const scenes::LoadedScene& scene) const;
  void refuse(const StreamPtr& stream, const Refusal& refusal, TenantId tenant = {});

  static Refusal refused(const protocol::Refused& message);
  static Refusal refused(protocol::RefusalCode code, std::string text);
  static Refusal departed();

  const NetShared& shared_;
  const uint16_t data_port_;
  asio::io_context& io_;
  SessionControl& control_;
  Lobby& lobby_;
};

}  // namespace gnomon::daemon
