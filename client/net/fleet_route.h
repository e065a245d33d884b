// Where a client connects that may have to do with a fleet: many servers behind one door. See protocol/WIRE.md, Fleets.
// Sends nothing and reads no clock.
#pragma once

#include <optional>
#include <random>

#include "client/net/address.h"
#include "common/clock.h"
#include "protocol/messages.h"

namespace gnomon::client {

class FleetRoute {
 public:
  // `door`: where the client was told to connect. `of_fleet`: whether it knows that to be a fleet's door.
  FleetRoute(Address door, bool of_fleet) : door_(std::move(door)), of_fleet_(of_fleet) {}

  // A session is open or was resumed: `welcome` may say where its server itself is.
  void welcomed(const protocol::Welcome& welcome) {
    home_.reset();
    refusals_ = attempts_ = 0;
    if (is_of_fleet(welcome)) home_ = Address{welcome.home_host, welcome.home_port};
  }

  struct Attempt {
    Address where;
    Nanoseconds patience{};  // then another one takes its place
  };
  // The next attempt to resume: at the server itself, where that is known, and at the door in turn.
  Attempt to_resume() {
    const bool at_home = home_ && attempts_++ % 2 == 0;
    return at_home ? Attempt{*home_, kPatienceAtHome} : Attempt{door_, kPatience};
  }

  // How long to wait until the door is asked again, which may send the client to another server; nullopt if that would be
  // of no use.
  std::optional<Nanoseconds> ask_door_again(protocol::RefusalCode refusal) {
    using enum protocol::RefusalCode;
    const bool of_one_server = refusal == over_capacity || refusal == draining || refusal == internal;
    if (!of_fleet_ || !of_one_server || refusals_++ >= kMostRefusals) return std::nullopt;
    return std::chrono::milliseconds(std::uniform_int_distribution(300, 600)(random_));
  }

  // Where datagrams go; `connected_to`: the numeric address of the control connection.
  static Address data_address(const protocol::Welcome& welcome, const std::string& connected_to) {
    return {is_of_fleet(welcome) ? welcome.data_host : connected_to, welcome.data_port};
  }

 private:
  static constexpr Nanoseconds kPatience = std::chrono::seconds(2);
  // Shorter, as there is another way, and a server that is gone for good does not answer at all.
  static constexpr Nanoseconds kPatienceAtHome = std::chrono::milliseconds(500);
  static constexpr uint32_t kMostRefusals = 5;

  static bool is_of_fleet(const protocol::Welcome& welcome) {
    return (welcome.features & protocol::kFeatureFleet) != 0;
  }

  Address door_;
  bool of_fleet_;
  std::optional<Address> home_;
  uint32_t attempts_ = 0;  // to resume, since the session was last welcomed
  uint32_t refusals_ = 0;
  std::minstd_rand random_{std::random_device{}()};
};

}  // namespace gnomon::client
