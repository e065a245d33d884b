#include "daemon/config/render_effects.h"

#include <algorithm>
#include <array>
#include <iterator>

#include "common/suggestion.h"

namespace gnomon::daemon {
namespace {

constexpr std::array<std::string_view, 4> kFormerPasses{"gbuffer", "trace", "pack", "readback"};

bool is_effect(std::string_view name) {
  return name == kHardShadows || name == kSoftShadows || name == kAmbientOcclusion;
}

bool contains(const std::vector<std::string>& list, std::string_view name) {
  return std::find(list.begin(), list.end(), name) != list.end();
}

// A list without effects is of renderer's passes, or empty: then all effects run.
bool runs(const RenderConfig& render, std::string_view effect) {
  return contains(render.passes, effect) || std::none_of(render.passes.begin(), render.passes.end(), is_effect);
}

}  // namespace

std::optional<std::string> misspelt_effect(const RenderConfig& render) {
  static const std::vector<std::string> kEffects{std::string(kHardShadows), std::string(kSoftShadows),
                                                 std::string(kAmbientOcclusion)};
  for (const std::string& name : render.passes) {
    const auto meant = suggestion(name, kEffects);
    if (!meant || is_effect(name)) continue;
    return "'" + name + "'; did you mean " + *meant + "? allowed: " + kEffects[0] + ", " + kEffects[1] + ", " +
           kEffects[2];
  }
  return std::nullopt;
}

std::vector<std::string> effects_of(const RenderConfig& render) {
  std::vector<std::string> effects{std::string(kHardShadows)};
  if (offers(render, kSoftShadows)) effects.emplace_back(kSoftShadows);
  if (offers(render, kAmbientOcclusion)) effects.emplace_back(kAmbientOcclusion);
  return effects;
}

SampleCounts most_samples(const RenderConfig& render) {
  return {runs(render, kSoftShadows) ? render.max_samples : 1,
          runs(render, kAmbientOcclusion) ? render.max_occlusion : Occlusion::none};
}

std::vector<std::string> renderer_passes(const RenderConfig& render) {
  std::vector<std::string> passes;
  std::remove_copy_if(render.passes.begin(), render.passes.end(), std::back_inserter(passes), is_effect);
  return passes;
}

bool offers(const RenderConfig& render, std::string_view pass) {
  if (pass == kHardShadows || contains(renderer_passes(render), pass)) return true;
  if (pass == kSoftShadows) return most_samples(render).per_light > 1;
  if (pass == kAmbientOcclusion) return most_samples(render).occlusion != Occlusion::none;
  return renderer_passes(render).empty() &&
         std::find(kFormerPasses.begin(), kFormerPasses.end(), pass) != kFormerPasses.end();
}

}  // namespace gnomon::daemon
