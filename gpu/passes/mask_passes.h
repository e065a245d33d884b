// The pass lists that end with a mask on the host, checked by their names alone, without a device.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"

namespace gnomon::gpu {

// A pass that a list for masks may have, and the resources that it hands on to others (gpu/passes/passes.h).
struct MaskPass {
  std::string_view name;
  std::vector<std::string_view> reads, writes;
};
const std::vector<MaskPass>& mask_passes();

// Error: an unknown name; a pass that reads what none before it writes; or no mask reaches the host.
Result<void> check_mask_passes(const std::vector<std::string>& passes);

}  // namespace gnomon::gpu
