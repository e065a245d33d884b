#include "daemon/web/scene_pages.h"

#include <algorithm>
#include <cctype>
#include <nlohmann/json.hpp>

#include "daemon/web/percent_encoding.h"

namespace gnomon::daemon::web {
namespace {

constexpr std::string_view kScene = "/scene/", kPack = ".pack";
constexpr size_t kHashDigits = 64;

bool is_hex(std::string_view text) {
  return std::all_of(text.begin(), text.end(),
                     [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); });
}

Response json_response(const nlohmann::json& page) {
  const std::string text = page.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  return {.fields = {{"Content-Type", "application/json"}, {"Cache-Control", "no-store"}},
          .body = std::make_shared<const std::vector<uint8_t>>(text.begin(), text.end())};
}

}  // namespace

std::optional<SceneTarget> scene_target(std::string_view target) {
  if (!target.starts_with(kScene)) return std::nullopt;
  target.remove_prefix(kScene.size());
  const size_t slash = target.rfind('/');
  if (target.ends_with(kPack) && slash != target.npos) {
    const std::string_view hash = target.substr(slash + 1, target.size() - slash - 1 - kPack.size());
    if (hash.size() == kHashDigits && is_hex(hash))
      return SceneTarget{percent_decoded(target.substr(0, slash)), std::string(hash)};
  }
  return SceneTarget{percent_decoded(target), ""};
}

Response scene_list(const std::vector<std::string>& names) { return json_response({{"scenes", names}}); }

Response scene_page(const std::string& name, const std::string& sha256, uint64_t bytes) {
  const nlohmann::json page{
      {"name", name},
      {"pack", std::string(kScene) + percent_encoded(name) + "/" + sha256 + std::string(kPack)},
      {"bytes", bytes},
      {"sha256", sha256}};
  return json_response(page);
}

Response pack_response(const Request& request, SharedBytes packed) {
  if (!accepts_brotli(request.accept_encoding)) return text_response(406, "a scene is sent in Brotli (br) alone");
  return {.fields = {{"Content-Type", "application/octet-stream"},
                     {"Content-Encoding", "br"},
                     {"Cache-Control", "private, max-age=31536000, immutable"},
                     {"Vary", "Authorization, Gnomon-Tenant"}},
          .body = std::move(packed)};
}

std::string bearer_token(std::string_view authorization) {
  constexpr std::string_view kScheme = "bearer ";
  const bool bearer = authorization.size() > kScheme.size() &&
                      std::equal(kScheme.begin(), kScheme.end(), authorization.begin(),
                                 [](char a, unsigned char b) { return a == std::tolower(b); });
  return bearer ? std::string(authorization.substr(kScheme.size())) : "";
}

}  // namespace gnomon::daemon::web
