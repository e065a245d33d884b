#include "client/view/debug_colours.h"

#include <algorithm>
#include <bit>

namespace gnomon::client {
namespace {

using gpu::light_buffer::End;

constexpr std::array kKinds{DebugKind::mask, DebugKind::bounds, DebugKind::lists};

// From few to many, from cold to warm.
struct Step {
  Colour colour;
  const char* name;
};
constexpr std::array<Step, 8> kSteps{{{{30, 30, 110}, "dark blue 0"},
                                      {{40, 90, 190}, "blue 1"},
                                      {{30, 150, 170}, "teal 2-3"},
                                      {{50, 180, 80}, "green 4-7"},
                                      {{160, 210, 50}, "lime 8-15"},
                                      {{250, 220, 50}, "yellow 16-31"},
                                      {{245, 130, 40}, "orange 32-63"},
                                      {{255, 60, 60}, "red 64 and more"}}};

}  // namespace

const char* to_string(DebugKind kind) {
  switch (kind) {
    case DebugKind::mask: return "mask";
    case DebugKind::bounds: return "bounds";
    case DebugKind::lists: return "lists";
  }
  return "unknown";
}

Result<DebugKind> parse_debug_kind(std::string_view name) {
  std::string allowed;
  for (const DebugKind kind : kKinds) {
    if (name == to_string(kind)) return kind;
    allowed += (allowed.empty() ? "" : ", ") + std::string(to_string(kind));
  }
  return Error{std::string("unknown view '").append(name) + "': allowed are " + allowed};
}

std::string debug_legend() {
  std::string steps;
  for (const Step& step : kSteps) steps += (steps.empty() ? "" : ", ") + std::string(step.name);
  return "Views, a picture for each light; black: no surface, slate: not asked (the light is behind, out of range "
         "or "
         "cone)\n"
         "  mask    the bits that came: white lit, maroon dark, between them in a penumbra\n"
         "  bounds  where the light buffer's query ends: green before the near bound (lit), red behind the cover "
         "bound "
         "(dark),\n"
         "          yellow in the list and lit, blue in the list and dark\n"
         "  lists   triangles that it tests: " +
         steps + "\n";
}

Colour mask_colour(uint32_t seen, uint32_t samples) {
  constexpr Colour kDark{120, 30, 50}, kLit{255, 255, 255};
  Colour between;
  for (size_t i = 0; i < between.size(); ++i)
    between[i] = static_cast<uint8_t>((kDark[i] * (samples - seen) + kLit[i] * seen) / samples);
  return between;
}

Colour bounds_colour(const gpu::light_buffer::Answer& answer) {
  switch (answer.end) {
    case End::near_plane: return {60, 180, 90};
    case End::cover_plane: return {200, 60, 50};
    case End::list: return answer.lit ? Colour{250, 220, 60} : Colour{60, 90, 230};
  }
  return kNotAsked;
}

Colour lists_colour(uint32_t tested) {
  return kSteps[std::min<size_t>(static_cast<size_t>(std::bit_width(tested)), kSteps.size() - 1)].colour;
}

}  // namespace gnomon::client
