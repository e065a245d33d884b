// Reads a glTF 2.0 scene (.gltf with files or data URIs, .glb). No header outside scenes/gltf/ exposes tinygltf.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "common/result.h"
#include "scenes/on_share.h"
#include "scenes/scene.h"

namespace gnomon::scenes {

// Limits for a file. They are checked before memory is allocated, so that a few bytes cannot cost a gigabyte: what is
// made of a file (texels, vertices, indices, keys, zeros that it does not even hold) is counted and may take
// base_memory_bytes and memory_bytes_per_byte more for each byte that was read. docs/scenes.md says what real files take.
struct LoadLimits {
  uint64_t max_file_bytes = uint64_t{2} << 30;  // the file and every buffer or image that it names
  uint64_t max_triangles = uint64_t{32} << 20;  // in the world, instances counted
  uint64_t max_instances = uint64_t{1} << 20;
  uint64_t max_texels = uint64_t{256} << 20;  // of all images together
  uint64_t base_memory_bytes = uint64_t{64} << 20;
  uint32_t memory_bytes_per_byte = 256;
  uint32_t max_scans = 64;  // of a JPEG: a decoder passes over the whole image for each
  uint32_t max_lights = 256;
  uint32_t max_node_depth = 1024;
  uint64_t max_scene_bytes = 0;  // predicted_bytes() of a scene that gets its geometry; 0: no limit
};

// Supported: the default scene (the first if none is named; all roots if there are no scenes), nodes with matrices or
// TRS, meshes with indices of any kind or none, triangle lists, strips and fans, sparse, interleaved, quantised and
// normalised accessors; KHR_lights_punctual, KHR_mesh_quantization, KHR_texture_transform; perspective cameras;
// animations of translation, rotation and scale, of cameras, meshes and lights and of nodes above them; materials' base
// colour, emission and alpha mode, base colour textures (PNG, JPEG). Left out: points and lines, orthographic cameras,
// animations of weights, vertex colours (alpha tests ignore their alpha). Skinned and morphing meshes stay as stored.
// Extensions that change the appearance only are ignored; a file that requires any other extension is refused. A base
// colour texture that cannot be read is left out with a warning, or is an error if an alpha test needs it.
//
// The file is untrusted: any bytes give a scene or an error, without a crash, a hang, an allocation beyond the limits,
// or a read outside the file's own folder. Blocking; any thread. The scene's name is the file's stem.
//
// `motions` replace the animations of the same property. It is an error if no node of that name, other than those whose
// matrix is skewed or flat, carries anything that could move, or if the longest animation lasts for more than 1000 of its
// periods.
Result<ScenePtr> load_scene(const std::filesystem::path& file, const LoadLimits& limits = {},
                            const std::vector<NodeMotion>& motions = {});

// Which base colour textures a server's scene has beside those that an alpha test needs.
enum class Colours : uint8_t {
  none,
  encoded  // all of them, as the files that they are (Texture::encoded): clients that get the scene from here draw them
};

// As load_scene for a server: the scene has its geometry, and of its textures those that an alpha test needs.
Result<ScenePtr> load_with_geometry(const std::filesystem::path& file, const LoadLimits& limits = {},
                                    const std::vector<NodeMotion>& motions = {}, Colours colours = Colours::none,
                                    const OnShare& on_share = {});

}  // namespace gnomon::scenes
