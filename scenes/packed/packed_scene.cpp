#include "scenes/packed/packed_scene.h"

#include "scenes/geometry/geometry.h"
#include "scenes/packed/archive.h"
#include "scenes/packed/check.h"

namespace gnomon::scenes {

template <>
inline constexpr bool kPlain<Cluster> = true;
template <>
inline constexpr bool kPlain<ClusterChunk> = true;

namespace {

template <class Archive, class Rep, class Period>
void visit(Archive& a, std::chrono::duration<Rep, Period>& duration) {
  Rep count = duration.count();
  a.plain(count);
  duration = std::chrono::duration<Rep, Period>(count);
}

template <class Archive>
void visit(Archive& a, Texture& t) {
  a.plain(t.width);
  a.plain(t.height);
  a.enumerator(t.wrap_u, Wrap::clamp_to_edge);
  a.enumerator(t.wrap_v, Wrap::clamp_to_edge);
  a.boolean(t.has_alpha);
  a.bulk(t.rgba);
  a.bulk(t.encoded);
}

template <class Archive>
void visit(Archive& a, Material& m) {
  a.text(m.name);
  a.plain(m.base_color);
  a.plain(m.emissive);
  a.plain(m.base_color_texture);
  a.enumerator(m.alpha_mode, AlphaMode::blend);
  a.plain(m.alpha_cutoff);
  a.boolean(m.double_sided);
}

template <class Archive>
void visit(Archive& a, Primitive& p) {
  a.plain(p.material);
  a.bulk(p.positions);
  a.bulk(p.normals);
  a.bulk(p.uvs);
  a.bulk(p.triangles);
}

template <class Archive>
void visit(Archive& a, Mesh& m) {
  a.text(m.name);
  a.each(m.primitives, [](Archive& b, Primitive& p) { visit(b, p); });
}

template <class Archive>
void visit(Archive& a, Instance& i) {
  a.plain(i.mesh);
  a.plain(i.object_to_world);
  a.plain(i.moved_by);
}

template <class Archive>
void visit(Archive& a, Light& l) {
  a.text(l.name);
  a.enumerator(l.type, LightType::directional);
  a.plain(l.position);
  a.plain(l.direction);
  a.plain(l.color);
  a.plain(l.intensity);
  a.plain(l.range);
  a.plain(l.inner_cone_cos);
  a.plain(l.outer_cone_cos);
  a.enumerator(l.area.shape, LightShape::rectangle);
  a.plain(l.area.u);
  a.plain(l.area.v);
  a.plain(l.moved_by);
}

template <class Archive>
void visit(Archive& a, Camera& c) {
  a.text(c.name);
  a.plain(c.rest.position);
  a.plain(c.rest.orientation);
  a.plain(c.rest.vertical_fov);
}

template <class Archive>
void visit(Archive& a, Channel& c) {
  a.plain(c.node);
  a.enumerator(c.path, Channel::Path::scale);
  a.enumerator(c.interpolation, Interpolation::cubic_spline);
  a.bulk(c.times);
  a.bulk(c.values);
}

template <class Archive>
void visit(Archive& a, NodeTransform& t) {
  a.plain(t.translation);
  a.plain(t.rotation);
  a.plain(t.scale);
  a.plain(t.matrix);
  a.boolean(t.has_matrix);
}

template <class Archive>
void visit(Archive& a, CameraPath& p) {
  a.plain(p.camera);
  a.plain(p.duration_seconds);
  a.each(p.chain, [](Archive& b, NodeTransform& t) { visit(b, t); });
  a.each(p.channels, [](Archive& b, Channel& c) { visit(b, c); });
}

template <class Archive>
void visit(Archive& a, MovingNode& n) {
  a.plain(n.parent);
  a.plain(n.parent_to_world);
  visit(a, n.local);
  a.each(n.channels, [](Archive& b, Channel& c) { visit(b, c); });
}

template <class Archive>
void visit(Archive& a, NodeMotion& m) {
  a.text(m.node);
  a.enumerator(m.kind, NodeMotion::Kind::shift);
  a.plain(m.vector);
  visit(a, m.period);
}

template <class Archive>
void visit(Archive& a, ClusterGroup& g) {
  a.plain(g.first_triangle);
  a.plain(g.triangle_count);
  a.plain(g.first_chunk);
  a.plain(g.chunk_count);
  a.boolean(g.masked);
  a.boolean(g.double_sided);
}

template <class Archive>
void visit(Archive& a, Geometry& g) {
  a.bulk(g.mesh.positions);
  a.bulk(g.mesh.normals);
  a.bulk(g.mesh.uvs);
  a.bulk(g.mesh.triangles);
  a.bulk(g.mesh.materials);
  a.plain(g.mesh.opaque_count);
  a.bulk(g.clusters.numbers);
  a.bulk(g.clusters.clusters);
  a.bulk(g.clusters.chunks);
  for (ClusterGroup& group : g.clusters.occluders) visit(a, group);
  for (ClusterGroup& group : g.clusters.others) visit(a, group);
}

void visit(PackWriter& a, GeometryPtr& geometry) {
  const bool made = geometry != nullptr;
  a.boolean(made);
  if (made) visit(a, const_cast<Geometry&>(*geometry));  // visits of a writer change nothing
}

void visit(PackReader& a, GeometryPtr& geometry) {
  bool made = false;
  a.boolean(made);
  if (!made) return;
  const auto read = std::make_shared<Geometry>();
  visit(a, *read);
  geometry = read;
}

template <class Archive>
void visit(Archive& a, Surroundings& s) {
  a.plain(s.ambient_above);
  a.plain(s.ambient_below);
  a.plain(s.ambient_reach);
  a.boolean(s.has_sky);
  a.plain(s.sky_zenith);
  a.plain(s.sky_horizon);
  a.plain(s.sky_ground);
  a.plain(s.sky_clouds);
}

template <class Archive>
void visit(Archive& a, Scene& s) {
  a.text(s.name);
  a.each(s.textures, [](Archive& b, Texture& t) { visit(b, t); });
  a.each(s.materials, [](Archive& b, Material& m) { visit(b, m); });
  a.each(s.meshes, [](Archive& b, Mesh& m) { visit(b, m); });
  a.each(s.instances, [](Archive& b, Instance& i) { visit(b, i); });
  a.each(s.lights, [](Archive& b, Light& l) { visit(b, l); });
  a.each(s.cameras, [](Archive& b, Camera& c) { visit(b, c); });
  a.each(s.paths, [](Archive& b, CameraPath& p) { visit(b, p); });
  a.each(s.moving_nodes, [](Archive& b, MovingNode& n) { visit(b, n); });
  visit(a, s.surroundings);
  visit(a, s.period);
  a.plain(s.bounds.min);
  a.plain(s.bounds.max);
  a.plain(s.triangle_count);
  a.plain(s.content_hash);
  visit(a, s.geometry);
}

template <class Archive>
void visit(Archive& a, LoadTask& t) {
  std::string file = t.file.string();
  a.text(file);
  t.file = file;
  a.each(t.motions, [](Archive& b, NodeMotion& m) { visit(b, m); });
  a.plain(t.limits.max_file_bytes);
  a.plain(t.limits.max_triangles);
  a.plain(t.limits.max_instances);
  a.plain(t.limits.max_texels);
  a.plain(t.limits.base_memory_bytes);
  a.plain(t.limits.memory_bytes_per_byte);
  a.plain(t.limits.max_scans);
  a.plain(t.limits.max_lights);
  a.plain(t.limits.max_node_depth);
  a.plain(t.limits.max_scene_bytes);
  a.enumerator(t.colours, Colours::encoded);
}

Result<void> flush(const PackWriter& writer, std::FILE* file) {
  if (writer.good() && std::fflush(file) == 0) return {};
  return Error{"the result cannot be written"};
}

}  // namespace

void write(PackWriter& writer, const LoadTask& task) {
  LoadTask copy = task;
  visit(writer, copy);
}

void read(PackReader& reader, LoadTask& task) { visit(reader, task); }

Result<void> write_outcome(const Result<ScenePtr>& scene, std::FILE* file) {
  PackWriter writer(file);
  writer.boolean(scene.has_value());
  if (scene) {
    visit(writer, const_cast<Scene&>(**scene));  // a writer changes nothing
  } else {
    writer.text(scene.error().message);
  }
  return flush(writer, file);
}

Result<ScenePtr> read_outcome(std::span<const std::byte> bytes, const LoadLimits& limits) {
  PackReader reader(bytes);
  bool loaded = false;
  reader.boolean(loaded);
  if (!loaded) {
    std::string why;
    reader.text(why);
    return Error{reader.good() && !why.empty() ? why : "its loader gave no answer"};
  }
  const auto scene = std::make_shared<Scene>();
  visit(reader, *scene);
  if (!reader.good() || !reader.at_end()) return Error{"its loader gave a broken answer: it is cut off"};
  if (const auto sound = check(*scene, limits); !sound) {
    return Error{"its loader gave a broken answer: " + sound.error().message};
  }
  return ScenePtr(scene);
}

}  // namespace gnomon::scenes
