// Compiles tinygltf's implementation.
#include <fstream>  // tinygltf's writers, unused here, name std::ofstream even with TINYGLTF_NO_FS

#define TINYGLTF_IMPLEMENTATION
#include "scenes/gltf/model.h"
