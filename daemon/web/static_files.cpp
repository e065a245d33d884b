#include "daemon/web/static_files.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "common/brotli.h"
#include "daemon/security/digests.h"
#include "daemon/web/page_source.h"

namespace gnomon::daemon::web {
namespace {

constexpr std::pair<std::string_view, const char*> kTypes[] = {
    {".html", "text/html; charset=utf-8"},
    {".css", "text/css; charset=utf-8"},
    {".js", "text/javascript; charset=utf-8"},
    {".svg", "image/svg+xml"},
    {".wasm", "application/wasm"},
};

const char* type_of(std::string_view path) {
  const auto found = std::find_if(std::begin(kTypes), std::end(kTypes),
                                  [&](const auto& type) { return path.ends_with(type.first); });
  return found == std::end(kTypes) ? "application/octet-stream" : found->second;
}

// Of bytes, quoted as the field has it; strong, as other bytes have another one.
std::string etag_of(std::span<const uint8_t> bytes) {
  const auto hash = sha256(bytes);
  std::string tag = base64(std::span(hash).first(15));
  std::replace(tag.begin(), tag.end(), '/', '_');
  return "\"" + tag + "\"";
}

// Whether a list of entity tags has this one (RFC 9110, 13.1.2: compared weakly).
bool lists(std::string_view field, std::string_view tag) {
  if (field == "*") return true;
  while (!field.empty()) {
    const size_t end = std::min(field.find(','), field.size());
    std::string_view one = field.substr(0, end);
    one.remove_prefix(std::min(one.find_first_not_of(" \t"), one.size()));
    one = one.substr(0, one.find_last_not_of(" \t") + 1);
    if (one.starts_with("W/")) one.remove_prefix(2);
    if (one == tag) return true;
    field.remove_prefix(std::min(end + 1, field.size()));
  }
  return false;
}

constexpr const char* kPage = "/index.html";
constexpr const char* kFirstModule = "/app.js";
constexpr const char* kScript = "/start.js";  // is put into the page

std::span<const uint8_t> bytes_of(const std::string& text) {
  return {reinterpret_cast<const uint8_t*>(text.data()), text.size()};
}

// The embedded files as they are served.
std::map<std::string, std::string> served(std::span<const EmbeddedFile> files, const std::string& fleet) {
  std::map<std::string, std::string> all;
  for (const EmbeddedFile& file : files) {
    const std::string bytes(file.bytes.begin(), file.bytes.end());
    all[file.path] = std::string_view(file.path).ends_with(".js") ? without_comments(bytes) : bytes;
  }
  if (const auto page = all.find(kPage); page != all.end()) {
    page->second =
        with_preloads(page->second, modules_of(kFirstModule, [&](const std::string& path) {
                        const auto found = all.find(path);
                        return found == all.end() ? std::nullopt : std::optional<std::string_view>(found->second);
                      }));
    if (!fleet.empty()) page->second = with_fleet(page->second, fleet);
    if (const auto script = all.find(kScript); script != all.end()) {
      page->second = with_script(page->second, kScript + 1, script->second);
    }
  }
  return all;
}

}  // namespace

StaticFiles StaticFiles::of(std::span<const EmbeddedFile> files, const std::string& fleet) {
  StaticFiles made;
  const auto texts = served(files, fleet);
  for (const auto& [path, text] : texts) {
    const std::span bytes = bytes_of(text);
    File file{type_of(path), etag_of(bytes),
              std::make_shared<const std::vector<uint8_t>>(bytes.begin(), bytes.end()), nullptr};
    const auto packed = gnomon::brotli(std::as_bytes(bytes));
    if (packed && packed->size() < bytes.size()) {
      const auto* const first = reinterpret_cast<const uint8_t*>(packed->data());
      file.brotli = std::make_shared<const std::vector<uint8_t>>(first, first + packed->size());
    }
    made.files_.emplace(path, std::move(file));
  }
  if (const auto index = made.files_.find(kPage); index != made.files_.end()) {
    if (const auto script = texts.find(kScript); script != texts.end()) {
      index->second.script = "'sha256-" + base64(sha256(bytes_of(script->second))) + "'";
    }
    made.files_.emplace("/", index->second);
  }
  return made;
}

Response StaticFiles::answer(const Request& request) const {
  const auto found = files_.find(request.target);
  if (found == files_.end()) return text_response(404, "no such page");
  const File& file = found->second;
  const bool packed = file.brotli && accepts_brotli(request.accept_encoding);
  // The two codings are two representations, each with a tag of its own (RFC 9110, 8.8.3.3).
  std::string etag = file.etag;
  if (packed) etag.insert(etag.size() - 1, "-br");
  Response response{.fields = {{"Content-Type", file.type},
                               {"ETag", etag},
                               {"Cache-Control", "no-cache"},
                               {"Vary", "Accept-Encoding"}},
                    .script = file.script};
  if (lists(request.if_none_match, etag)) {
    response.status = 304;
    return response;
  }
  if (packed) response.fields.emplace_back("Content-Encoding", "br");
  response.body = packed ? file.brotli : file.plain;
  return response;
}

}  // namespace gnomon::daemon::web
