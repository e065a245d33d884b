// What scenes/scene.h promises of every loaded scene.
#pragma once

#include <string>

#include "scenes/scene.h"

namespace gnomon::scenes::testing {

// The first promise that is broken, or "".
std::string broken_promise(const Scene& scene);

}  // namespace gnomon::scenes::testing
