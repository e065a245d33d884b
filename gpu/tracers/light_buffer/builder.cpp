#include "gpu/tracers/light_buffer/builder.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "common/clock.h"
#include "gpu/tracers/light_buffer/parallel.h"

namespace gnomon::gpu::light_buffer {
namespace {

constexpr size_t kChunk = 4096;  // triangles set up by one call

class Build {
 public:
  // Only one root in `stride` is built, to learn what all would take.
  Build(const scenes::WorldMesh& mesh, const scenes::Bounds& bounds, const BuildSettings& settings,
        const Detail& detail, size_t stride)
      : mesh_(mesh),
        bounds_(bounds),
        detail_(detail),
        stride_(stride),
        threads_(settings.threads != 0 ? settings.threads : std::max(1u, std::thread::hardware_concurrency())) {}

  void add(const exact::TracedLight& light, LightBuffer& out) {
    LightFaces faces = light_faces(light, bounds_);
    faces.view.roots = static_cast<uint32_t>(out.nodes.size());
    out.nodes.resize(out.nodes.size() + faces.faces.size() * kRootCount, Node{});
    out.lights.push_back(faces.view);
    for (size_t f = 0; f < faces.faces.size(); ++f) {
      add_face(faces, f, light, out, faces.view.roots + static_cast<uint32_t>(f) * kRootCount);
    }
  }

 private:
  // What cannot block a segment of this light: beyond its range.
  bool reaches(const exact::TracedLight& light, const std::array<glm::dvec3, 3>& corners) const {
    if (light.kind == 2 || light.reach == 0.0f) return true;
    const glm::dvec3 low = glm::min(corners[0], glm::min(corners[1], corners[2]));
    const glm::dvec3 high = glm::max(corners[0], glm::max(corners[1], corners[2]));
    const glm::dvec3 nearest = glm::clamp(glm::dvec3(0.0), low, high);
    return glm::length(nearest) <= 1.001 * light.reach;
  }

  std::vector<Footprint> footprints(const LightFaces& faces, const Face& face, const exact::TracedLight& light) {
    const size_t count = mesh_.triangles.size();
    std::vector<std::vector<Footprint>> chunks((count + kChunk - 1) / kChunk);
    parallel_for(chunks.size(), threads_, [&](size_t c) {
      for (size_t t = c * kChunk; t < std::min(count, (c + 1) * kChunk); ++t) {
        std::array<glm::dvec3, 3> corners;
        for (int k = 0; k < 3; ++k) {
          corners[static_cast<size_t>(k)] = glm::dvec3(mesh_.positions[mesh_.triangles[t][k]]) - faces.reference;
        }
        if (!reaches(light, corners)) continue;
        std::optional<Footprint> f = footprint(face, faces.diameter, corners);
        if (!f || !shown(face, *f)) continue;
        f->triangle = static_cast<uint32_t>(t);
        f->can_cover = f->can_cover && t < mesh_.opaque_count;
        chunks[c].push_back(*f);
      }
    });
    std::vector<Footprint> all;
    for (const std::vector<Footprint>& chunk : chunks) all.insert(all.end(), chunk.begin(), chunk.end());
    return all;
  }

  static bool shown(const Face& face, const Footprint& f) {
    const uint32_t last = (1u << kRootLevel) - 1;
    const Rect first = face.node_rect(kRootLevel, 0, 0);
    const Rect final = face.node_rect(kRootLevel, last, last);
    return meets(f, {first.u0, first.v0, final.u1, final.v1});
  }

  // Root indices of one axis whose nodes may meet [low, high].
  static std::pair<uint32_t, uint32_t> root_span(double low, double high, double face_low, double face_size) {
    const double side = 1u << kRootLevel;
    const double first = std::floor((low - face_low) / face_size * side - 2.01);
    const double last = std::floor((high - face_low) / face_size * side + 0.01);
    return {static_cast<uint32_t>(std::clamp(first, 0.0, side - 1)),
            static_cast<uint32_t>(std::clamp(last, 0.0, side - 1))};
  }

  void add_face(const LightFaces& faces, size_t f, const exact::TracedLight& light, LightBuffer& out,
                uint32_t root) {
    const Face& face = faces.faces[f];
    const std::vector<Footprint> all = faces.used[f] ? footprints(faces, face, light) : std::vector<Footprint>();
    std::vector<std::vector<const Footprint*>> met(kRootCount);
    for (const Footprint& footprint : all) {
      const auto [i0, i1] = root_span(footprint.box.u0, footprint.box.u1, face.low_u, face.size);
      const auto [j0, j1] = root_span(footprint.box.v0, footprint.box.v1, face.low_v, face.size);
      for (uint32_t j = j0; j <= j1; ++j) {
        for (uint32_t i = i0; i <= i1; ++i) met[(j << kRootLevel) + i].push_back(&footprint);
      }
    }
    std::vector<Subtree> trees(kRootCount);
    parallel_for(kRootCount, threads_, [&](size_t r) {
      if ((r * 7 + f) % stride_ != 0) return;
      trees[r] = build_subtree(face, detail_, static_cast<uint32_t>(r) % (1u << kRootLevel),
                               static_cast<uint32_t>(r) >> kRootLevel, std::move(met[r]));
    });
    for (uint32_t r = 0; r < kRootCount; ++r) append(trees[r], root + r, out);
  }

  static void append(const Subtree& tree, uint32_t root, LightBuffer& out) {
    const uint32_t node_base = static_cast<uint32_t>(out.nodes.size()) - 1;  // tree node 1 comes first
    const uint32_t list_base = static_cast<uint32_t>(out.lists.size());
    for (size_t n = 0; n < tree.nodes.size(); ++n) {
      Node node = tree.nodes[n];
      if (node.children != kNone) node.children += node_base;
      if (node.list != kNone) node.list += list_base;
      if (n == 0) {
        out.nodes[root] = node;
      } else {
        out.nodes.push_back(node);
      }
    }
    out.lists.insert(out.lists.end(), tree.lists.begin(), tree.lists.end());
  }

  const scenes::WorldMesh& mesh_;
  const scenes::Bounds& bounds_;
  const Detail detail_;
  const size_t stride_;
  const unsigned threads_;
};

void count(LightBuffer& buffer) {
  Statistics& s = buffer.statistics;
  s.bytes = buffer.memory_bytes();
  for (const Node& node : buffer.nodes) {
    if (node.list == kNone) continue;
    const uint32_t length = buffer.lists[node.list];
    ++s.leaves;
    s.entries += length;
    s.longest_list = std::max(s.longest_list, length);
  }
}

// About half the memory.
Detail coarser(Detail detail) {
  if (detail.usual_level > kRootLevel) --detail.usual_level;
  detail.longest_walk *= 1.5;
  return detail;
}

LightBuffer build_at(const scenes::WorldMesh& mesh, const scenes::Bounds& bounds,
                     std::span<const exact::TracedLight> lights, const BuildSettings& settings,
                     const Detail& detail, size_t stride) {
  LightBuffer buffer;
  Build build(mesh, bounds, settings, detail, stride);
  for (size_t l = 0; l < lights.size(); ++l) {
    if (settings.progress && stride == 1) {
      settings.progress(static_cast<double>(l) / static_cast<double>(lights.size()));
    }
    build.add(lights[l], buffer);
  }
  return buffer;
}

// From a sixteenth of the roots.
uint64_t estimated_bytes(const scenes::WorldMesh& mesh, const scenes::Bounds& bounds,
                         std::span<const exact::TracedLight> lights, const BuildSettings& settings,
                         const Detail& detail) {
  constexpr size_t kStride = 16;
  const LightBuffer sample = build_at(mesh, bounds, lights, settings, detail, kStride);
  const uint64_t roots = 6 * kRootCount * sizeof(Node) * lights.size();
  const uint64_t bytes = sample.memory_bytes();
  return bytes > roots ? roots + (bytes - roots) * kStride : bytes;
}

}  // namespace

uint64_t default_budget(size_t lights) {
  return std::min<uint64_t>(512, 160 + 32 * static_cast<uint64_t>(lights)) << 20;
}

LightBuffer build(const scenes::WorldMesh& mesh, const scenes::Bounds& bounds,
                  std::span<const exact::TracedLight> lights, const BuildSettings& settings) {
  const TimePoint start = Clock::now();
  constexpr int kMostSteps = 10;
  const uint64_t budget = settings.budget_bytes != 0 ? settings.budget_bytes : default_budget(lights.size());
  Detail detail = settings.detail;
  int step = 0;
  for (; step < kMostSteps && estimated_bytes(mesh, bounds, lights, settings, detail) > budget; ++step) {
    detail = coarser(detail);
  }
  LightBuffer buffer = build_at(mesh, bounds, lights, settings, detail, 1);
  for (; step < kMostSteps && buffer.memory_bytes() > budget; ++step) {
    detail = coarser(detail);
    buffer = build_at(mesh, bounds, lights, settings, detail, 1);
  }
  if (settings.progress) settings.progress(1.0);
  count(buffer);
  buffer.statistics.build_seconds = to_seconds(Clock::now() - start);
  return buffer;
}

}  // namespace gnomon::gpu::light_buffer
