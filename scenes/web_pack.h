// A scene as browsers get it: web/PACK.md.
#pragma once

#include <cstddef>
#include <vector>

#include "common/result.h"
#include "scenes/scene.h"

namespace gnomon::scenes {

// The pack, not compressed; equal scenes give equal bytes. Blocking; any thread. Its triangles are those of
// geometry_of(scene), in that order. Error: a texture's file was not kept (Colours::encoded), or the pack is larger than
// browsers can hold.
Result<std::vector<std::byte>> web_pack(const Scene& scene);

}  // namespace gnomon::scenes
