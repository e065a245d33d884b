// How many sessions there may be: of all, of a tenant, of an address. A seat is held as long as it exists.
#pragma once

#include <asio/ip/address.hpp>

#include <map>
#include <mutex>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include "common/ids.h"
#include "daemon/config.h"
#include "protocol/messages.h"

namespace gnomon::daemon {

class Seats;

// Move-only; any thread may drop it. Outlived by its Seats.
class Seat {
 public:
  Seat(Seats& seats, TenantId tenant, asio::ip::address address)
      : seats_(&seats), tenant_(tenant), address_(std::move(address)) {}
  Seat(Seat&& other) noexcept
      : seats_(std::exchange(other.seats_, nullptr)), tenant_(other.tenant_), address_(other.address_) {}
  Seat& operator=(Seat&&) = delete;
  ~Seat();

 private:
  Seats* seats_;
  TenantId tenant_;
  asio::ip::address address_;
};

// Any thread.
class Seats {
 public:
  explicit Seats(const Config& config);

  // A seat, or why there is none.
  std::variant<Seat, protocol::Refused> take(TenantId tenant, const asio::ip::address& address);

  uint32_t taken() const;

 private:
  friend class Seat;
  void give_back(TenantId tenant, const asio::ip::address& address);

  const uint32_t max_all_;
  const uint32_t max_per_address_;
  std::vector<uint32_t> max_of_tenant_;  // 0: no limit

  mutable std::mutex mutex_;  // guards what follows
  uint32_t all_ = 0;
  std::vector<uint32_t> of_tenant_;
  std::map<asio::ip::address, uint32_t> of_address_;
};

}  // namespace gnomon::daemon
