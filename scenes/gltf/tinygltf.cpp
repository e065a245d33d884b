// The one place where tinygltf is compiled.
#include <fstream>  // its writers, unused here, name std::ofstream even without file access

#define TINYGLTF_IMPLEMENTATION
#include "scenes/gltf/model.h"
