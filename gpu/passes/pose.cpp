// Copies the moving geometry from one host buffer to the slot's parts of the scene's buffers.
#include <array>
#include <cstring>

#include "gpu/passes/passes.h"

namespace gnomon::gpu {
namespace {

// Offsets in moving_host. What belongs to the hierarchy lies at the same distances in moving_bvh.
struct Layout {
  uint64_t positions = 0, normals = 0, uvs = 0, triangles = 0, materials = 0, nodes = 0, leaves = 0, parts = 0,
           bytes = 0;

  Layout(uint32_t vertex_count, uint32_t triangle_count) {
    const auto take = [this](uint64_t count, size_t size) {
      const uint64_t at = bytes;
      bytes = (at + count * size + 15) / 16 * 16;
      return at;
    };
    positions = take(vertex_count, sizeof(glm::vec3));
    normals = take(vertex_count, sizeof(glm::vec3));
    uvs = take(vertex_count, sizeof(glm::vec2));
    triangles = take(triangle_count, sizeof(glm::uvec3));
    materials = take(triangle_count, sizeof(uint32_t));
    nodes = take(2 * uint64_t{triangle_count}, sizeof(BvhNode));
    leaves = take(triangle_count, sizeof(BvhTriangle));
    parts = take(kMostParts, sizeof(BvhPart));
  }
  explicit Layout(const scenes::MovingMeshSize& size) : Layout(size.vertices, size.triangles) {}
};

class PosePass : public Pass {
 public:
  std::string_view name() const override { return "pose"; }
  const PassLayout* layout() const override { return nullptr; }
  std::vector<Port> ports() const override {
    const auto host = [](const Capacity& c) { return Layout(c.moving_vertices, c.moving_triangles).bytes; };
    const auto bvh = [](const Capacity& c) {
      const Layout layout(c.moving_vertices, c.moving_triangles);
      return layout.bytes - layout.nodes;
    };
    return {{resource::kMovingHost, Use::copy_source, {{}, host, MemoryUse::upload}},
            {resource::kMovingBvh, Use::copy_target, {{}, bvh}}};
  }

  void record(const FrameContext& frame) const override {
    const scenes::WorldMesh& mesh = frame.posed.mesh;
    if (mesh.triangles.empty()) return;
    const ResidentScene& scene = frame.scene;
    const Layout from(scene.moving_size());
    const auto copy = [&](const Buffer& into, uint64_t at, uint64_t first, size_t count, size_t size) {
      const VkBufferCopy region{at, first * size, count * size};
      vkCmdCopyBuffer(frame.commands, frame.ports[0].buffer->handle(), into.handle(), 1, &region);
    };
    const uint64_t vertex = scene.moving_place(frame.slot).first_vertex,
                   triangle = scene.moving_place(frame.slot).first_triangle;
    copy(scene.buffers().positions, from.positions, vertex, mesh.positions.size(), sizeof(glm::vec3));
    copy(scene.buffers().normals, from.normals, vertex, mesh.normals.size(), sizeof(glm::vec3));
    copy(scene.buffers().uvs, from.uvs, vertex, mesh.uvs.size(), sizeof(glm::vec2));
    copy(scene.buffers().triangles, from.triangles, triangle, mesh.triangles.size(), sizeof(glm::uvec3));
    copy(scene.buffers().triangle_materials, from.materials, triangle, mesh.materials.size(), sizeof(uint32_t));
    copy(*frame.ports[1].buffer, from.nodes, 0, from.bytes - from.nodes, 1);
    wait(frame.commands);
  }

 private:
  // A barrier of its own, because the scene's buffers are not resources of the plan.
  static void wait(VkCommandBuffer commands) {
    VkMemoryBarrier2 copied{};
    copied.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2;
    copied.srcStageMask = VK_PIPELINE_STAGE_2_COPY_BIT;
    copied.srcAccessMask = VK_ACCESS_2_TRANSFER_WRITE_BIT;
    copied.dstStageMask = VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT | VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT |
                          VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT;
    copied.dstAccessMask = VK_ACCESS_2_SHADER_STORAGE_READ_BIT;
    VkDependencyInfo dependency{};
    dependency.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO;
    dependency.memoryBarrierCount = 1;
    dependency.pMemoryBarriers = &copied;
    vkCmdPipelineBarrier2(commands, &dependency);
  }
};

}  // namespace

Result<std::unique_ptr<Pass>> make_pose_pass() { return std::unique_ptr<Pass>(std::make_unique<PosePass>()); }

void write_moving(std::span<std::byte> into, const ResidentScene& scene, const PosedScene& posed, uint32_t slot) {
  const Layout to(scene.moving_size());
  const auto write = [&](uint64_t at, const auto& list) {
    if (!list.empty()) std::memcpy(into.data() + at, list.data(), std::as_bytes(std::span(list)).size());
  };
  std::vector<glm::uvec3> triangles = posed.mesh.triangles;
  for (glm::uvec3& corners : triangles) corners += scene.moving_place(slot).first_vertex;
  write(to.positions, posed.mesh.positions);
  write(to.normals, posed.mesh.normals);
  write(to.uvs, posed.mesh.uvs);
  write(to.triangles, triangles);
  write(to.materials, posed.mesh.materials);
  write(to.nodes, posed.bvh.nodes);
  write(to.leaves, posed.bvh.triangles);
  write(to.parts, posed.parts);
}

}  // namespace gnomon::gpu
