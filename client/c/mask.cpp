// Masks: reading their contents.
#include <gnomon/gnomon.h>

#include <algorithm>

#include "client/c/convert.h"
#include "client/c/handle.h"
#include "client/c/versioned.h"

namespace {

using namespace gnomon;
using namespace gnomon::client::c;

uint32_t microseconds(Nanoseconds time) { return static_cast<uint32_t>(to_microseconds(time)); }

bool has_light(const gnomon_mask* mask, uint32_t light) {
  return mask && light < mask->received->mask.planes.light_count();
}

}  // namespace

extern "C" {

gnomon_result gnomon_mask_get_view(const gnomon_mask* mask, gnomon_mask_view* view) {
  if (!mask) return GNOMON_BAD_ARGUMENT;
  const client::ReceivedMasks& received = *mask->received;
  const client::AssembledFrame& frame = received.mask;
  gnomon_mask_view made{};
  made.index = received.index;
  made.camera = to_c(received.camera);
  made.width = frame.grid.width;
  made.height = frame.grid.height;
  made.lights = frame.planes.light_count();
  made.tiles_x = frame.grid.tiles_x();
  made.tiles_y = frame.grid.tiles_y();
  made.words = frame.words.data();
  made.word_count = frame.words.size();
  made.missing_tiles = mask->missing_tiles.data();
  made.missing_tile_count = mask->missing_tiles.size();
  made.scene_time_us = frame.moment.scene_time_us;
  made.lights_version = frame.moment.lights_version;
  made.response_us = microseconds(received.response);
  made.server_us = frame.server_us;
  made.gpu_us = frame.gpu_us;
  made.bytes = frame.payload_bytes;
  made.planes = frame.grid.planes;
  made.samples = 1;
  for (uint32_t light = 0; light < made.lights; ++light)
    made.samples = std::max(made.samples, frame.planes.samples(light));
  made.occlusion = static_cast<gnomon_occlusion>(frame.planes.occlusion());
  made.occlusion_plane = frame.planes.first_of_occlusion();
  return write_versioned(made, view) ? GNOMON_OK : GNOMON_BAD_ARGUMENT;
}

int gnomon_mask_lit(const gnomon_mask* mask, uint32_t light, uint32_t x, uint32_t y) {
  const int seen = gnomon_mask_seen(mask, light, x, y);
  return seen < 0 ? -1 : 2 * seen >= gnomon_mask_samples(mask, light);
}

int gnomon_mask_seen(const gnomon_mask* mask, uint32_t light, uint32_t x, uint32_t y) {
  if (!has_light(mask, light)) return -1;
  const client::AssembledFrame& frame = mask->received->mask;
  if (x >= frame.grid.width || y >= frame.grid.height) return -1;
  return static_cast<int>(frame.seen(x, y, light));
}

int gnomon_mask_samples(const gnomon_mask* mask, uint32_t light) {
  return has_light(mask, light) ? static_cast<int>(mask->received->mask.planes.samples(light)) : -1;
}

int gnomon_mask_first_plane(const gnomon_mask* mask, uint32_t light) {
  return has_light(mask, light) ? static_cast<int>(mask->received->mask.planes.first(light)) : -1;
}

int gnomon_mask_open(const gnomon_mask* mask, uint32_t x, uint32_t y) {
  if (!mask) return -1;
  const client::AssembledFrame& frame = mask->received->mask;
  if (x >= frame.grid.width || y >= frame.grid.height || !frame.planes.counts_occlusion(x, y)) return -1;
  return static_cast<int>(frame.planes.open_segments({frame.grid, frame.words}, x, y));
}

int gnomon_mask_has_tile(const gnomon_mask* mask, uint32_t light, uint32_t tile_x, uint32_t tile_y) {
  if (!has_light(mask, light)) return -1;
  const client::AssembledFrame& frame = mask->received->mask;
  const TileGrid& grid = frame.grid;
  if (tile_x >= grid.tiles_x() || tile_y >= grid.tiles_y()) return -1;
  const size_t tile = size_t{tile_y} * grid.tiles_x() + tile_x;
  const uint32_t first = frame.planes.first(light);
  for (uint32_t plane = first; plane < first + frame.planes.count(light); ++plane)
    if (!frame.arrived[size_t{plane} * grid.tile_count() + tile]) return 0;
  return 1;
}

gnomon_result gnomon_mask_get_light(const gnomon_mask* mask, uint32_t light, gnomon_light* out) {
  if (!mask || light >= mask->received->lights.size()) return GNOMON_BAD_ARGUMENT;
  return write_versioned(to_c(mask->received->lights[light]), out) ? GNOMON_OK : GNOMON_BAD_ARGUMENT;
}

void gnomon_mask_free(gnomon_mask* mask) { delete mask; }

}  // extern "C"
