#include "tests/unit/gpu/embree_oracle.h"

#include <embree3/rtcore.h>

#include <atomic>
#include <thread>

#include "common/clock.h"
#include "gpu/scene/resident_scene.h"
#include "scenes/light_samples.h"
#include "scenes/world_mesh.h"

namespace gnomon::test {

using gpu::exact::ShadowSegment;
using gpu::exact::SurfacePoint;
using gpu::exact::TracedLight;

struct EmbreeOracle::State {
  scenes::ScenePtr source;
  scenes::WorldMesh mesh;
  std::vector<TracedLight> lights;
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
  double build_seconds = 0;
};

namespace {

// Lets rays through where the alpha test of the hit triangle fails.
void alpha_filter(const RTCFilterFunctionNArguments* args) {
  const auto& state = *static_cast<const EmbreeOracle::State*>(args->geometryUserPtr);
  for (unsigned i = 0; i < args->N; ++i) {
    if (args->valid[i] != -1) continue;
    const unsigned triangle = state.mesh.opaque_count + RTCHitN_primID(args->hit, args->N, i);
    const float u = RTCHitN_u(args->hit, args->N, i), v = RTCHitN_v(args->hit, args->N, i);
    const glm::uvec3 t = state.mesh.triangles[triangle];
    const glm::vec2 uv = (1.0f - u - v) * state.mesh.uvs[t.x] + u * state.mesh.uvs[t.y] + v * state.mesh.uvs[t.z];
    if (!scenes::passes_alpha_test(*state.source, state.mesh.materials[triangle], uv)) args->valid[i] = 0;
  }
}

void attach(EmbreeOracle::State& state, uint32_t first, size_t count, bool masked) {
  if (count == 0) return;
  RTCGeometry geometry = rtcNewGeometry(state.device, RTC_GEOMETRY_TYPE_TRIANGLE);
  // Embree reads vertices 16 bytes at a time: its own padded copy.
  auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), state.mesh.positions.size()));
  std::copy_n(&state.mesh.positions[0].x, 3 * state.mesh.positions.size(), vertices);
  auto* indices = static_cast<uint32_t*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(uint32_t), count));
  std::copy_n(&state.mesh.triangles[first].x, 3 * count, indices);
  if (masked) {
    rtcSetGeometryUserData(geometry, &state);
    rtcSetGeometryOccludedFilterFunction(geometry, alpha_filter);
  }
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(state.scene, geometry);
  rtcReleaseGeometry(geometry);
}

bool is_free(const EmbreeOracle::State& state, const ShadowSegment& s) {
  RTCRay ray{s.origin.x, s.origin.y, s.origin.z, 0.0f, s.direction.x, s.direction.y, s.direction.z, 0.0f,
             1.0f,       ~0u,        0,          0};
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(state.scene, &context, &ray);
  return ray.tfar >= 0.0f;
}

// Of the points of the light at `offsets`.
std::optional<uint32_t> count_free(const EmbreeOracle::State& state, const glm::vec3& camera,
                                   const gpu::SurfaceSample& sample, const TracedLight& light,
                                   std::span<const glm::vec3> offsets) {
  if (sample.triangle == 0) return std::nullopt;
  const ShadowSegment middle = gpu::exact::shadow_segment(camera, {sample.position, sample.normal}, light);
  if (!middle.traced) return std::nullopt;
  uint32_t seen = 0;
  for (const glm::vec3& offset : offsets) {
    const ShadowSegment s = gpu::exact::sample_segment(middle.origin, sample.normal, light.position + offset);
    seen += s.traced && is_free(state, s);
  }
  return seen;
}

// Calls row(y) for every row, on so many threads.
template <class Row>
void for_rows(uint32_t rows, unsigned threads, Row row) {
  std::atomic<uint32_t> next = 0;
  const auto work = [&] {
    for (uint32_t y = next++; y < rows; y = next++) row(y);
  };
  std::vector<std::thread> others;
  for (unsigned i = 1; i < threads; ++i) others.emplace_back(work);
  work();
  for (std::thread& t : others) t.join();
}

// Occlusion answers for the segments of one 4x4 block: bit y * 4 + x set where lit.
class Block {
 public:
  Block(const EmbreeOracle::State& state, const gpu::CameraView& camera, const TileGrid& grid,
        std::span<const gpu::SurfaceSample> samples, uint32_t x, uint32_t y)
      : state_(state), camera_(camera.position) {
    for (uint32_t i = 0; i < 16; ++i) {
      const uint32_t px = x + i % 4, py = y + i / 4;
      if (px >= grid.width || py >= grid.height) continue;
      const gpu::SurfaceSample& sample = samples[size_t{py} * grid.width + px];
      if (sample.triangle == 0) continue;
      surfaces_[i] = {sample.position, sample.normal};
      shown_ |= 1u << i;
    }
  }

  uint32_t lit(uint32_t light, EmbreeQuery query) const {
    return query == EmbreeQuery::single ? lit_single(light) : lit_packet(light);
  }

 private:
  ShadowSegment segment(uint32_t i, uint32_t light) const {
    return gpu::exact::shadow_segment(camera_, surfaces_[i], state_.lights[light]);
  }

  uint32_t lit_single(uint32_t light) const {
    uint32_t bits = 0;
    for (uint32_t i = 0; i < 16; ++i) {
      if (!(shown_ >> i & 1)) continue;
      const ShadowSegment s = segment(i, light);
      if (s.traced && is_free(state_, s)) bits |= 1u << i;
    }
    return bits;
  }

  uint32_t lit_packet(uint32_t light) const {
    alignas(64) int valid[16];
    alignas(64) RTCRay16 rays{};
    uint32_t traced = 0;
    for (uint32_t i = 0; i < 16; ++i) {
      valid[i] = 0;
      // Where vectors are narrower than the packet, Embree divides it and goes by the ray's ends alone.
      rays.tfar[i] = -1.0f;
      if (!(shown_ >> i & 1)) continue;
      const ShadowSegment s = segment(i, light);
      if (!s.traced) continue;
      valid[i] = -1;
      traced |= 1u << i;
      rays.org_x[i] = s.origin.x, rays.org_y[i] = s.origin.y, rays.org_z[i] = s.origin.z;
      rays.dir_x[i] = s.direction.x, rays.dir_y[i] = s.direction.y, rays.dir_z[i] = s.direction.z;
      rays.tfar[i] = 1.0f, rays.mask[i] = ~0u, rays.id[i] = i;
    }
    if (traced == 0) return 0;
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    rtcOccluded16(valid, state_.scene, &context, &rays);
    uint32_t bits = 0;
    for (uint32_t i = 0; i < 16; ++i)
      if ((traced >> i & 1) && rays.tfar[i] >= 0.0f) bits |= 1u << i;
    return bits;
  }

  const EmbreeOracle::State& state_;
  glm::vec3 camera_;
  SurfacePoint surfaces_[16]{};
  uint32_t shown_ = 0;
};

// Where bit y * 4 + x of block (bx, by) of a tile stands in the tile's word.
uint64_t spread(uint32_t bits, uint32_t bx, uint32_t by) {
  uint64_t word = 0;
  for (uint32_t row = 0; row < 4; ++row) word |= uint64_t{bits >> (4 * row) & 15u} << ((by * 4 + row) * 8 + bx * 4);
  return word;
}

}  // namespace

EmbreeOracle::EmbreeOracle(scenes::ScenePtr scene, bool robust) : state_(std::make_unique<State>()) {
  state_->source = scene;
  state_->mesh = scenes::build_world_mesh(*scene);
  for (const scenes::Light& light : scene->lights)
    state_->lights.push_back(gpu::traced_light(light, scene->bounds));
  const TimePoint start = Clock::now();
  state_->device = rtcNewDevice(nullptr);
  state_->scene = rtcNewScene(state_->device);
  rtcSetSceneFlags(state_->scene, robust ? RTC_SCENE_FLAG_ROBUST : RTC_SCENE_FLAG_NONE);
  const uint32_t opaque = state_->mesh.opaque_count;
  attach(*state_, 0, opaque, false);
  attach(*state_, opaque, state_->mesh.triangles.size() - opaque, true);
  rtcCommitScene(state_->scene);
  state_->build_seconds = to_seconds(Clock::now() - start);
}

EmbreeOracle::~EmbreeOracle() {
  rtcReleaseScene(state_->scene);
  rtcReleaseDevice(state_->device);
}

bool EmbreeOracle::occluded(glm::vec3 from, glm::vec3 to) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  const glm::vec3 along = to - from;
  RTCRay ray{};
  ray.org_x = from.x, ray.org_y = from.y, ray.org_z = from.z;
  ray.dir_x = along.x, ray.dir_y = along.y, ray.dir_z = along.z;
  ray.tfar = 1.0f;
  ray.mask = ~0u;
  rtcOccluded1(state_->scene, &context, &ray);
  return ray.tfar < 0.0f;
}

double EmbreeOracle::build_seconds() const { return state_->build_seconds; }

std::vector<uint64_t> EmbreeOracle::trace(const gpu::CameraView& camera, const TileGrid& grid,
                                          std::span<const gpu::SurfaceSample> samples, EmbreeQuery query,
                                          unsigned threads) const {
  std::vector<uint64_t> words(grid.word_count());
  for_rows(grid.tiles_y(), threads, [&](uint32_t ty) {
    for (uint32_t tx = 0; tx < grid.tiles_x(); ++tx)
      for (uint32_t block = 0; block < 4; ++block) {
        const uint32_t bx = block % 2, by = block / 2;
        const Block pixels(*state_, camera, grid, samples, tx * 8 + bx * 4, ty * 8 + by * 4);
        for (uint32_t light = 0; light < grid.planes; ++light)
          words[size_t{light} * grid.tile_count() + ty * grid.tiles_x() + tx] |=
              spread(pixels.lit(light, query), bx, by);
      }
  });
  return words;
}

std::vector<std::optional<uint32_t>> EmbreeOracle::count(const gpu::CameraView& camera, const TileGrid& grid,
                                                         std::span<const gpu::SurfaceSample> surfaces,
                                                         uint32_t samples, unsigned threads) const {
  const size_t pixels = size_t{grid.width} * grid.height;
  std::vector<std::optional<uint32_t>> counts(state_->lights.size() * pixels);
  for (size_t light = 0; light < state_->lights.size(); ++light) {
    const std::vector<glm::vec3> offsets = scenes::sample_offsets(state_->source->lights[light].area, samples);
    for_rows(grid.height, threads, [&](uint32_t y) {
      for (uint32_t x = 0; x < grid.width; ++x) {
        const size_t pixel = size_t{y} * grid.width + x;
        counts[light * pixels + pixel] =
            count_free(*state_, camera.position, surfaces[pixel], state_->lights[light],
                       std::span(offsets).subspan(scenes::sample_pattern(x, y) * samples, samples));
      }
    });
  }
  return counts;
}

}  // namespace gnomon::test
