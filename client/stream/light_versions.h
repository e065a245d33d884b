// The lights of a scene by their version: frames that are still on their way may show lights of an earlier one.
#pragma once

#include <map>
#include <vector>

#include "protocol/messages.h"

namespace gnomon::client {

class LightVersions {
 public:
  // Forgets the oldest version beyond the newest kMostVersions.
  void add(uint32_t version, const std::vector<protocol::LightInfo>& lights) {
    lights_[version] = lights;
    if (lights_.size() > kMostVersions) lights_.erase(lights_.begin());
  }
  void clear() { lights_.clear(); }

  // nullptr if the version is unknown: slices may overtake the message that describes their lights.
  const std::vector<protocol::LightInfo>* find(uint32_t version) const {
    const auto found = lights_.find(version);
    return found == lights_.end() ? nullptr : &found->second;
  }

 private:
  static constexpr size_t kMostVersions = 16;

  std::map<uint32_t, std::vector<protocol::LightInfo>> lights_;
};

}  // namespace gnomon::client
