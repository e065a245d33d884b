// Writes a Stage as one binary glTF 2.0 file.
#pragma once

#include <cstdint>
#include <vector>

#include "scenes/assets/stage.h"

namespace gnomon::scenes::assets {

// The bytes of the .glb file. Equal stages give equal bytes.
std::vector<uint8_t> to_glb(const Stage& stage);

}  // namespace gnomon::scenes::assets
