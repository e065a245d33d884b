// What render.passes names: effects, after the dissertation's RenderConfig, in words of what clients get from them.
//
//   hard_shadows        one segment for each pixel and light
//   soft_shadows        beside it: several, to points of lights that have an extent, for clients that ask for them
//   ambient_occlusion   how much of a surface's ambient light nothing near hides, likewise
//
// Before there were effects the list named the renderer's own passes (gbuffer, trace, pack, readback). That still works:
// the renderer runs them, and all effects are on offer.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/config/config.h"

namespace gnomon::daemon {

inline constexpr std::string_view kHardShadows = "hard_shadows";
inline constexpr std::string_view kSoftShadows = "soft_shadows";
inline constexpr std::string_view kAmbientOcclusion = "ambient_occlusion";

// What is said of the first name in the list that is nearly an effect's; nullopt: there is none.
std::optional<std::string> misspelt_effect(const RenderConfig& render);

// What runs, in order: hard shadows always, the others if the list names them or no effect at all, and
// render.max_samples and render.max_occlusion leave something of them.
std::vector<std::string> effects_of(const RenderConfig& render);

// The most samples that this allows.
SampleCounts most_samples(const RenderConfig& render);

// The names in the list that are no effects, for the renderer; if empty, its own list.
std::vector<std::string> renderer_passes(const RenderConfig& render);

// Whether a client may insist on it: an effect that runs, or what clients could name before there were effects.
bool offers(const RenderConfig& render, std::string_view pass);

}  // namespace gnomon::daemon
