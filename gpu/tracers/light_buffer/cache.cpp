#include "gpu/tracers/light_buffer/cache.h"

#include <unistd.h>
#include <xxhash.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstring>
#include <fstream>

namespace gnomon::gpu::light_buffer {
namespace {

// To be increased whenever the same scene and settings would give other bytes, or bytes with another meaning.
constexpr uint32_t kVersion = 8;
constexpr const char* kEnding = ".lightbuffer";
constexpr std::array<char, 8> kMagic = {'G', 'N', 'O', 'M', 'O', 'N', 'L', 'B'};

static_assert(std::endian::native == std::endian::little, "files are little-endian");

struct Header {
  std::array<char, 8> magic = kMagic;
  uint32_t version = kVersion;
  uint32_t longest_list = 0;
  scenes::ContentHash content{};
  uint64_t build = 0;
  uint64_t lights = 0, grid = 0, leaves = 0, entries = 0;  // elements, in this order behind the header
  uint64_t payload_hash = 0;
  uint64_t header_hash = 0;  // of all above
};
static_assert(sizeof(Header) == 88);

uint64_t header_hash(const Header& header) { return XXH3_64bits(&header, offsetof(Header, header_hash)); }

uint64_t payload_bytes(const Header& h) {
  return h.lights * sizeof(LightView) + h.grid * sizeof(uint32_t) + h.leaves * sizeof(Leaf) +
         h.entries * sizeof(ListEntry);
}

uint64_t payload_hash(const LightBuffer& buffer) {
  uint64_t hash = XXH3_64bits(buffer.lights.data(), buffer.lights.size() * sizeof(LightView));
  hash = XXH3_64bits_withSeed(buffer.grid.data(), buffer.grid.size() * sizeof(uint32_t), hash);
  hash = XXH3_64bits_withSeed(buffer.leaves.data(), buffer.leaves.size() * sizeof(Leaf), hash);
  return XXH3_64bits_withSeed(buffer.entries.data(), buffer.entries.size() * sizeof(ListEntry), hash);
}

Header describe(const CacheKey& key, const LightBuffer& buffer) {
  Header header;
  header.longest_list = buffer.statistics.longest_list;
  header.content = key.content;
  header.build = key.build;
  header.lights = buffer.lights.size();
  header.grid = buffer.grid.size();
  header.leaves = buffer.leaves.size();
  header.entries = buffer.entries.size();
  header.payload_hash = payload_hash(buffer);
  header.header_hash = header_hash(header);
  return header;
}

template <class T>
void read_array(std::ifstream& in, std::vector<T>& array, uint64_t count) {
  array.resize(count);
  in.read(reinterpret_cast<char*>(array.data()), static_cast<std::streamsize>(count * sizeof(T)));
}

template <class T>
void write_array(std::ofstream& out, const std::vector<T>& array) {
  out.write(reinterpret_cast<const char*>(array.data()), static_cast<std::streamsize>(array.size() * sizeof(T)));
}

// The fault of the header; empty if it is valid. The file is untrusted, and this is checked before memory is allocated.
std::string fault(const Header& header, const CacheKey& key, uint64_t file_bytes) {
  if (header.magic != kMagic) return "is no light buffer";
  if (header.version != kVersion) return "is of version " + std::to_string(header.version);
  if (header.header_hash != header_hash(header)) return "has a damaged header";
  if (header.content != key.content || header.build != key.build) return "belongs to another scene";
  if (std::max({header.lights, header.grid, header.leaves, header.entries}) > file_bytes ||
      file_bytes != sizeof(Header) + payload_bytes(header))
    return "has the wrong length";
  return "";
}

struct CachedFile {
  std::filesystem::path path;
  std::filesystem::file_time_type used;
  uint64_t bytes = 0;
};

// Of whatever cannot be read, nothing: another process may be removing it.
std::vector<CachedFile> cached_files(const std::filesystem::path& folder) {
  std::vector<CachedFile> files;
  std::error_code failed;
  for (std::filesystem::directory_iterator at(folder, failed), end; !failed && at != end; at.increment(failed)) {
    if (at->path().filename().string().find(kEnding) == std::string::npos) continue;
    std::error_code gone;
    const CachedFile file{at->path(), at->last_write_time(gone), gone ? 0 : at->file_size(gone)};
    if (!gone) files.push_back(file);
  }
  return files;
}

}  // namespace

CacheKey cache_key(const scenes::ContentHash& content, const BuildSettings& settings, const scenes::WorldMesh& mesh,
                   const scenes::Bounds& bounds, std::span<const exact::TracedLight> lights) {
  const std::array<double, 5> numbers = {settings.detail.cost_per_byte, static_cast<double>(settings.most_work),
                                         static_cast<double>(settings.detail.finest_level),
                                         static_cast<double>(settings.budget_bytes),
                                         static_cast<double>(mesh.opaque_count)};
  uint64_t hash = XXH3_64bits_withSeed(numbers.data(), sizeof(numbers), kVersion);
  hash = XXH3_64bits_withSeed(&bounds, sizeof(bounds), hash);
  hash = XXH3_64bits_withSeed(mesh.positions.data(), mesh.positions.size() * sizeof(glm::vec3), hash);
  hash = XXH3_64bits_withSeed(mesh.triangles.data(), mesh.triangles.size() * sizeof(glm::uvec3), hash);
  // The radii come last and only if there are any, so that files from before lights had radii are found.
  constexpr size_t kPlain = offsetof(exact::TracedLight, radius);
  std::vector<std::byte> plain(lights.size() * kPlain);
  std::vector<float> radii;
  for (size_t i = 0; i < lights.size(); ++i) {
    std::memcpy(plain.data() + i * kPlain, &lights[i], kPlain);
    radii.push_back(lights[i].radius);
  }
  hash = XXH3_64bits_withSeed(plain.data(), plain.size(), hash);
  if (std::any_of(radii.begin(), radii.end(), [](float radius) { return radius > 0.0f; }))
    hash = XXH3_64bits_withSeed(radii.data(), radii.size() * sizeof(float), hash);
  return {content, hash};
}

std::filesystem::path cache_file(const std::filesystem::path& folder, const CacheKey& key) {
  std::array<char, 20> build{};
  std::snprintf(build.data(), build.size(), "%016llx", static_cast<unsigned long long>(key.build));
  return folder / (scenes::to_hex(key.content) + "-" + build.data() + kEnding);
}

std::optional<LightBuffer> load(const std::filesystem::path& folder, const CacheKey& key, std::string& why) {
  why.clear();
  const std::filesystem::path file = cache_file(folder, key);
  std::error_code none;
  const uint64_t bytes = std::filesystem::file_size(file, none);
  std::ifstream in(file, std::ios::binary);
  if (none || !in) return std::nullopt;
  Header header;
  in.read(reinterpret_cast<char*>(&header), sizeof(header));
  why = in ? fault(header, key, bytes) : "has the wrong length";
  if (!why.empty()) return std::nullopt;
  LightBuffer buffer;
  read_array(in, buffer.lights, header.lights);
  read_array(in, buffer.grid, header.grid);
  read_array(in, buffer.leaves, header.leaves);
  read_array(in, buffer.entries, header.entries);
  if (!in || payload_hash(buffer) != header.payload_hash) {
    why = "is damaged";
    return std::nullopt;
  }
  std::filesystem::last_write_time(file, std::filesystem::file_time_type::clock::now(), none);
  buffer.statistics.bytes = buffer.memory_bytes();
  buffer.statistics.leaves = header.leaves;
  buffer.statistics.entries = header.entries;
  buffer.statistics.longest_list = header.longest_list;
  return buffer;
}

Result<void> save(const std::filesystem::path& folder, const CacheKey& key, const LightBuffer& buffer,
                  uint64_t most_bytes) {
  std::error_code failed;
  std::filesystem::create_directories(folder, failed);
  if (failed) return Error{"creating '" + folder.string() + "': " + failed.message()};
  const std::filesystem::path file = cache_file(folder, key);
  // The name is unique to the process, because two daemons may share the folder.
  const std::filesystem::path part = file.string() + "." + std::to_string(::getpid());
  const Header header = describe(key, buffer);
  const uint64_t bytes = sizeof(header) + payload_bytes(header);
  if (bytes > most_bytes) {
    return Error{"'" + file.string() + "' would have " + std::to_string(bytes) +
                 " bytes, more than the cache may hold"};
  }
  if (most_bytes != kNoLimit) trim(folder, most_bytes - bytes);
  std::ofstream out(part, std::ios::binary | std::ios::trunc);
  out.write(reinterpret_cast<const char*>(&header), sizeof(header));
  write_array(out, buffer.lights);
  write_array(out, buffer.grid);
  write_array(out, buffer.leaves);
  write_array(out, buffer.entries);
  const bool written = out.flush().good();
  const std::error_code refused(written ? 0 : errno, std::generic_category());
  out.close();
  if (out) std::filesystem::rename(part, file, failed);
  if (out && !failed) return {};
  std::error_code ignored;
  std::filesystem::remove(part, ignored);
  return Error{"writing '" + file.string() + "': " + (failed ? failed : refused).message()};
}

Trimmed trim(const std::filesystem::path& folder, uint64_t most_bytes) {
  std::vector<CachedFile> files = cached_files(folder);
  std::ranges::sort(files, {}, &CachedFile::used);
  uint64_t left = 0;
  for (const CachedFile& file : files) left += file.bytes;
  Trimmed trimmed;
  for (const CachedFile& file : files) {
    if (left <= most_bytes) break;
    std::error_code failed;
    if (!std::filesystem::remove(file.path, failed)) continue;
    left -= file.bytes;
    ++trimmed.files;
    trimmed.bytes += file.bytes;
  }
  return trimmed;
}

}  // namespace gnomon::gpu::light_buffer
