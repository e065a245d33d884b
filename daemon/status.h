// What an operator may ask about a running daemon, as plain data. Net threads publish theirs about once a second.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "common/ids.h"
#include "protocol/messages.h"
#include "scheduler/cost_model.h"

namespace gnomon::daemon {

struct DeviceStatus {
  std::string name;
  std::string driver;
  std::string tracer;
  std::string raster;
  std::string pci_address;
};

// What is known of the scenes' costs.
using CostModels = std::map<SceneId, scheduler::CostModel>;

struct SessionStatus {
  SessionId id;
  TenantId tenant;
  std::string scene;
  std::string address;  // of its data; empty: none has proved itself yet
  uint32_t width = 0;
  uint32_t height = 0;
  protocol::Stats stats;
};

// The newest value that one thread published, for others to look at. Neither side waits for the other's work: what
// is locked is the exchange of a pointer.
template <class T>
class Published {
 public:
  void publish(T value) {
    auto next = std::make_shared<const T>(std::move(value));
    std::lock_guard lock(mutex_);
    value_.swap(next);
  }

  std::shared_ptr<const T> get() const {
    std::lock_guard lock(mutex_);
    return value_;
  }

 private:
  mutable std::mutex mutex_;
  std::shared_ptr<const T> value_ = std::make_shared<const T>();
};

}  // namespace gnomon::daemon
