// Whether a scene keeps what scenes/scene.h promises. The loader's scenes do; those of another process are checked.
#pragma once

#include "common/result.h"
#include "scenes/loader.h"
#include "scenes/scene.h"

namespace gnomon::scenes {

// The error names what is broken. Takes time in proportion to the scene's size.
Result<void> check(const Scene& scene, const LoadLimits& limits);

}  // namespace gnomon::scenes
