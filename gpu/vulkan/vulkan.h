// Includes Vulkan, and converts its results to error messages.
#pragma once

#include <vulkan/vulkan.h>

#include <string_view>

#include "common/result.h"

namespace gnomon::gpu {

std::string_view to_string(VkResult result);

// An error such as "creating a buffer: out of device memory", where `doing` is "creating a buffer".
Error vulkan_error(VkResult result, std::string_view doing);

}  // namespace gnomon::gpu
