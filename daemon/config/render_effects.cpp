#include "daemon/config/render_effects.h"

#include <algorithm>
#include <array>
#include <iterator>

namespace gnomon::daemon {
namespace {

constexpr std::array<std::string_view, 4> kFormerPasses{"gbuffer", "trace", "pack", "readback"};

bool is_effect(std::string_view name) { return name == kHardShadows || name == kSoftShadows; }

bool contains(const std::vector<std::string>& list, std::string_view name) {
  return std::find(list.begin(), list.end(), name) != list.end();
}

}  // namespace

std::vector<std::string> effects_of(const RenderConfig& render) {
  std::vector<std::string> effects{std::string(kHardShadows)};
  if (most_samples(render) > 1) effects.emplace_back(kSoftShadows);
  return effects;
}

uint32_t most_samples(const RenderConfig& render) {
  const bool hard_alone = contains(render.passes, kHardShadows) && !contains(render.passes, kSoftShadows);
  return hard_alone ? 1 : render.max_samples;
}

std::vector<std::string> renderer_passes(const RenderConfig& render) {
  std::vector<std::string> passes;
  std::remove_copy_if(render.passes.begin(), render.passes.end(), std::back_inserter(passes), is_effect);
  return passes;
}

bool offers(const RenderConfig& render, std::string_view pass) {
  if (pass == kHardShadows || contains(renderer_passes(render), pass)) return true;
  if (pass == kSoftShadows) return most_samples(render) > 1;
  return renderer_passes(render).empty() &&
         std::find(kFormerPasses.begin(), kFormerPasses.end(), pass) != kFormerPasses.end();
}

}  // namespace gnomon::daemon
