#include "scenes/gltf/document.h"

#include <algorithm>
#include <cstring>
#include <optional>
#include <string_view>

#include "common/log.h"
#include "scenes/gltf/json_text.h"
#include "scenes/gltf/uri.h"

namespace gnomon::scenes::gltf {
namespace {

using nlohmann::json;
using View = std::span<const uint8_t>;

constexpr uint32_t kMagic = 0x46546c67;  // "glTF"
constexpr uint32_t kJson = 0x4e4f534a;
constexpr uint32_t kBin = 0x004e4942;

struct Parts {
  bool binary = false;
  std::string_view json;
  std::optional<View> bin;
};

uint32_t u32(View bytes, size_t at) {
  return uint32_t{bytes[at]} | uint32_t{bytes[at + 1]} << 8 | uint32_t{bytes[at + 2]} << 16 |
         uint32_t{bytes[at + 3]} << 24;
}

std::string_view as_text(View bytes) { return {reinterpret_cast<const char*>(bytes.data()), bytes.size()}; }

// glTF 2.0, 4.4: a header of 12 bytes, then chunks. The first is JSON; a BIN chunk, if any, is the second.
Result<Parts> split_glb(View file) {
  if (file.size() < 20) return Error{"the .glb ends within its header"};
  if (u32(file, 4) != 2) return Error{"the .glb has version " + std::to_string(u32(file, 4)) + "; only 2 is read"};
  const size_t length = u32(file, 8);
  if (length > file.size()) return Error{"the .glb is shorter than its header says: truncated"};
  const View body = file.first(length);
  Parts parts;
  parts.binary = true;
  size_t at = 12;
  for (size_t chunk = 0; at + 8 <= body.size(); ++chunk) {
    const size_t size = u32(body, at);
    const uint32_t type = u32(body, at + 4);
    if (size > body.size() - at - 8) return Error{"a chunk of the .glb ends beyond the file: truncated"};
    const View content = body.subspan(at + 8, size);
    if (chunk == 0 && type != kJson) return Error{"the first chunk of the .glb is not JSON"};
    if (chunk == 0) parts.json = as_text(content);
    if (chunk == 1 && type == kBin) parts.bin = content;
    at += 8 + std::min((size + 3) & ~size_t{3}, body.size() - at - 8);
  }
  if (parts.json.empty()) return Error{"the .glb has no JSON"};
  return parts;
}

Result<Parts> split(View file) {
  if (file.size() >= 4 && u32(file, 0) == kMagic) return split_glb(file);
  return Parts{false, as_text(file), std::nullopt};
}

std::string text_of(const json& object, const char* key) {
  const auto it = object.find(key);
  return it != object.end() && it->is_string() ? it->get<std::string>() : std::string();
}

// A buffer's content, cut to its declared length; bytes that had to be read are kept in `document.owned`.
Result<View> buffer_content(const json& buffer, bool first, const Parts& parts, Document& document) {
  const auto length = buffer.find("byteLength");
  if (length == buffer.end() || !length->is_number_unsigned()) return Error{"has no valid byteLength"};
  const auto declared = length->get<uint64_t>();
  const std::string uri = text_of(buffer, "uri");
  View content;
  if (!uri.empty()) {
    Result<Bytes> bytes = read_uri(document.folder, uri, document.budget);
    if (!bytes) return bytes.error();
    document.owned.push_back(std::move(*bytes));
    content = document.owned.back();
  } else if (first && parts.bin) {
    content = *parts.bin;
  } else if (first && parts.binary) {
    return Error{"is missing: the .glb has no BIN chunk"};
  } else {
    return View{};
  }
  if (content.size() < declared) {
    return Error{"holds " + std::to_string(content.size()) + " bytes, not the " + std::to_string(declared) +
                 " that it declares"};
  }
  return content.first(declared);
}

Result<void> read_buffers(const json& root, const Parts& parts, Document& document) {
  const auto buffers = root.find("buffers");
  if (buffers == root.end()) return {};
  for (const json& buffer : *buffers) {
    const size_t index = document.buffers.size();
    Result<View> content = buffer_content(buffer, index == 0, parts, document);
    if (!content) return Error{"buffer " + std::to_string(index) + ": " + content.error().message};
    document.buffers.push_back(*content);
  }
  const auto lacking = std::count_if(document.buffers.begin(), document.buffers.end(),
                                     [](View buffer) { return buffer.data() == nullptr; });
  if (lacking > 0) log::warning("glTF leaves buffers without bytes", {{"buffers", lacking}});
  return {};
}

// How many entries the file's arrays have together: accessors, nodes, ...
uint64_t entries(const json& root) {
  uint64_t count = 0;
  for (const auto& [name, value] : root.items()) count += value.is_array() ? value.size() : 0;
  return count;
}

// An accessor without a buffer view is zeros, which tinygltf does not allow of indices: it gets a view of a buffer that
// has no bytes, from which everything is read as zero.
void give_views_to_zeros(json& root, Document& document) {
  const auto accessors = root.find("accessors");
  if (accessors == root.end()) return;
  json& views = root["bufferViews"];
  const size_t view = views.size();
  bool needed = false;
  for (json& accessor : *accessors) {
    if (accessor.contains("bufferView")) continue;
    accessor["bufferView"] = view;
    needed = true;
  }
  if (!needed) return;  // an empty list is as good as none
  views.push_back({{"buffer", document.buffers.size()}, {"byteLength", 1}});
  document.buffers.emplace_back();
}

void read_image_sources(const json& root, Document& document) {
  const auto images = root.find("images");
  if (images == root.end()) return;
  for (const json& image : *images) {
    ImageSource source;
    source.uri = text_of(image, "uri");
    const auto view = image.find("bufferView");
    if (view != image.end() && view->is_number_unsigned() && view->get<uint64_t>() < INT32_MAX) {
      source.buffer_view = view->get<int>();
    }
    document.images.push_back(std::move(source));
  }
}

std::string one_line(std::string text) {
  while (!text.empty() && text.back() == '\n') text.pop_back();
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

// Gives tinygltf the JSON only. It throws on some input that it does not expect.
Result<void> read_structure(json root, tinygltf::Model& model) {
  root.erase("buffers");
  root.erase("images");
  std::string error;
  std::string warning;
  bool read = false;
  try {
    const std::string text = root.dump();
    tinygltf::TinyGLTF reader;
    read =
        reader.LoadASCIIFromString(&model, &error, &warning, text.data(), static_cast<unsigned>(text.size()), "");
  } catch (const std::exception& e) {
    error = e.what();
  }
  if (!read) return Error{"its structure is not glTF: " + one_line(error)};
  if (!error.empty()) log::debug("glTF oddity", {{"what", one_line(error)}});
  return {};
}

}  // namespace

Result<Bytes> read_uri(Folder& folder, const std::string& uri, Budget& budget) {
  return is_data_uri(uri) ? decode_data_uri(uri) : folder.read(uri, budget);
}

bool Document::lacks_bytes(int buffer_view) const {
  const auto found = entry(model.bufferViews, buffer_view, "buffer view");
  const auto buffer = found ? entry(buffers, (*found)->buffer, "buffer") : found.error();
  return buffer && (*buffer)->data() == nullptr;
}

Result<View> Document::view(int buffer_view) const {
  const auto found = entry(model.bufferViews, buffer_view, "buffer view");
  if (!found) return found.error();
  const tinygltf::BufferView& v = **found;
  const auto buffer = entry(buffers, v.buffer, "buffer");
  if (!buffer) return buffer.error();
  const View bytes = **buffer;
  if (v.byteOffset > bytes.size() || v.byteLength > bytes.size() - v.byteOffset) {
    return Error{"buffer view " + std::to_string(buffer_view) + " ends beyond its buffer"};
  }
  return bytes.subspan(v.byteOffset, v.byteLength);
}

Result<Document> open_document(const std::filesystem::path& file, const LoadLimits& limits) {
  Result<Folder> folder = Folder::of(file);
  if (!folder) return folder.error();
  Document document{.folder = std::move(*folder),
                    .model = {},
                    .buffers = {},
                    .images = {},
                    .extras = {},
                    .owned = {},
                    .budget = Budget(limits)};
  Result<Bytes> bytes = document.folder.read_scene_file(document.budget);
  if (!bytes) return bytes.error();
  document.owned.push_back(std::move(*bytes));
  const Result<Parts> parts = split(document.owned.front());
  if (!parts) return parts.error();
  Result<json> root = parse_gltf_json(parts->json, document.extras);
  if (!root) return root.error();
  // tinygltf allocates up to 2 KB for an empty entry of an array, which is three bytes of JSON.
  constexpr uint64_t kEntryBytes = 2048;
  if (const auto ok = document.budget.spend(entries(*root), kEntryBytes); !ok) {
    return Error{"its structure " + ok.error().message};
  }
  if (const auto ok = read_buffers(*root, *parts, document); !ok) return ok.error();
  give_views_to_zeros(*root, document);
  read_image_sources(*root, document);
  if (const auto ok = read_structure(std::move(*root), document.model); !ok) return ok.error();
  return document;
}

}  // namespace gnomon::scenes::gltf
