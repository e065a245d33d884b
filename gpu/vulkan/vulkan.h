// Vulkan, and its results as errors for people.
#pragma once

#include <vulkan/vulkan.h>

#include <string_view>

#include "common/result.h"

namespace gnomon::gpu {

std::string_view to_string(VkResult result);

// "creating a buffer: out of device memory".
Error vulkan_error(VkResult result, std::string_view doing);

}  // namespace gnomon::gpu
