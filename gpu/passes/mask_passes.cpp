#include "gpu/passes/mask_passes.h"

#include <algorithm>
#include <set>

namespace gnomon::gpu {
namespace {

constexpr std::string_view kLast = "readback";

std::string all_names() {
  std::string names;
  for (const MaskPass& pass : mask_passes()) names.append(names.empty() ? "" : ", ").append(pass.name);
  return names;
}

}  // namespace

const std::vector<MaskPass>& mask_passes() {
  static const std::vector<MaskPass> all{
      {"gbuffer", {}, {"triangle_id"}},
      {"gbuffer_compute", {}, {"triangle_id"}},
      {"gbuffer_all", {}, {"triangle_id"}},
      {"trace", {"triangle_id"}, {"masks", "valid_bits"}},
      {"pack", {"masks", "valid_bits"}, {"classes", "mixed_places"}},
      {kLast, {"masks", "valid_bits", "classes", "mixed_places"}, {}},
  };
  return all;
}

Result<void> check_mask_passes(const std::vector<std::string>& passes) {
  std::set<std::string_view> written;
  for (const std::string& name : passes) {
    const auto& all = mask_passes();
    const auto pass = std::find_if(all.begin(), all.end(), [&](const MaskPass& p) { return p.name == name; });
    if (pass == all.end()) return Error{"no pass for masks is called '" + name + "'; there are " + all_names()};
    for (const std::string_view resource : pass->reads) {
      if (written.contains(resource)) continue;
      return Error{"pass '" + name + "' reads '" + std::string(resource) + "', which no pass before it writes"};
    }
    written.insert(pass->writes.begin(), pass->writes.end());
  }
  if (std::find(passes.begin(), passes.end(), kLast) == passes.end()) {
    return Error{"the pass list has no 'readback': no mask would reach the host"};
  }
  return {};
}

}  // namespace gnomon::gpu
