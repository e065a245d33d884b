// How many sessions there may be: of all, of a tenant, of an address; and what they may ask for together. A seat is
// held as long as it exists.
#pragma once

#include <asio/ip/address.hpp>

#include <map>
#include <mutex>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include "common/ids.h"
#include "daemon/config/config.h"
#include "protocol/messages.h"
#include "scheduler/admission.h"

namespace gnomon::daemon {

class Seats;

// Move-only; any thread may drop it. Outlived by its Seats.
class Seat {
 public:
  Seat(Seats& seats, TenantId tenant, asio::ip::address address)
      : seats_(&seats), tenant_(tenant), address_(std::move(address)) {}
  Seat(Seat&& other) noexcept
      : seats_(std::exchange(other.seats_, nullptr)),
        tenant_(other.tenant_),
        address_(other.address_),
        booking_(other.booking_) {}
  Seat& operator=(Seat&&) = delete;
  ~Seat();

 private:
  friend class Seats;

  Seats* seats_;
  TenantId tenant_;
  asio::ip::address address_;
  std::optional<scheduler::Booking> booking_;
};

// Any thread.
class Seats {
 public:
  // `devices`: how many there are to be booked.
  explicit Seats(const Config& config, size_t devices = 1);

  // A seat, or why there is none.
  std::variant<Seat, protocol::Refused> take(TenantId tenant, const asio::ip::address& address);

  // Books what the session asks for on its seat, or says why there is no room and what would fit.
  std::optional<scheduler::Misfit> book(Seat& seat, const scheduler::Demand& demand,
                                        const scheduler::CostModel& model);

  // Other limits from now on, and perhaps further tenants; who has a seat keeps it. `config` lists tenants by id.
  void set_limits(const Config& config);

  uint32_t taken() const;

 private:
  friend class Seat;
  void give_back(const Seat& seat);

  const double devices_;
  mutable std::mutex mutex_;  // guards what follows
  uint32_t max_all_ = 0;
  uint32_t max_per_address_ = 0;
  std::vector<uint32_t> max_of_tenant_;  // 0: no limit
  scheduler::Admission admission_;
  uint32_t all_ = 0;
  std::vector<uint32_t> of_tenant_;
  std::map<asio::ip::address, uint32_t> of_address_;
};

}  // namespace gnomon::daemon
