// Reads a glTF 2.0 scene (.gltf with files or data URIs, .glb). tinygltf stands behind this header alone.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "common/result.h"
#include "scenes/scene.h"

namespace gnomon::scenes {

// What a file may ask of us. Checked before memory is reserved: a few bytes never buy a gigabyte.
struct LoadLimits {
  uint64_t max_file_bytes = uint64_t{2} << 30;  // the file and every buffer or image that it names
  uint64_t max_triangles = uint64_t{32} << 20;  // in the world, instances counted
  uint64_t max_instances = uint64_t{1} << 20;
  uint64_t max_texels = uint64_t{256} << 20;  // of all images together
  uint32_t max_lights = 256;
  uint32_t max_node_depth = 1024;
};

// Read: the default scene (the first where none is named; all roots where there are no scenes), nodes with matrices
// or TRS, meshes with indices of any kind or none, triangle lists, strips and fans, sparse, interleaved, quantised and
// normalised accessors; KHR_lights_punctual, KHR_mesh_quantization, KHR_texture_transform; perspective cameras; animations of
// translation, rotation and scale, of cameras, meshes and lights and of nodes above them; materials' base colour, emission and alpha mode, base colour textures (PNG, JPEG).
// Left out: points and lines, orthographic cameras, animations of weights, vertex colours (their alpha takes no part in
// alpha tests). Skinned and morphing meshes stay as stored. Appearance extensions are ignored; a file that requires
// any other extension is refused. A base colour texture that cannot be read is left out with a warning, unless an
// alpha test needs it.
//
// Any bytes give a scene or an error: no crash, no hang, no allocation beyond the limits, no read outside the
// file's own folder. Blocking; any thread. The scene's name is the file's stem.
//
// `motions` move nodes in the place of animations of the same property. Error too: no node of that name carries
// anything that could move, or it has a matrix.
Result<ScenePtr> load_scene(const std::filesystem::path& file, const LoadLimits& limits = {},
                            const std::vector<NodeMotion>& motions = {});

}  // namespace gnomon::scenes
