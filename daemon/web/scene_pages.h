// What browsers are told of a scene, and the scene itself, by their addresses:
//
//   /scene/                   JSON: the names of all
//   /scene/NAME               JSON: where its pack is
//   /scene/NAME/SHA256.pack   the pack, which is never another one under this address
//
// Pure.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/web/web_response.h"

namespace gnomon::daemon::web {

struct SceneTarget {
  std::string name;    // decoded; if empty, of the list
  std::string sha256;  // if empty, of the page that says where the pack is
};

// nullopt if the target is none of these.
std::optional<SceneTarget> scene_target(std::string_view target);

Response scene_list(const std::vector<std::string>& names);
// `bytes`: of the pack, uncompressed.
Response scene_page(const std::string& name, const std::string& sha256, uint64_t bytes);
// `packed`: in Brotli. 406 for one who does not take it.
Response pack_response(const Request& request, SharedBytes packed);

// The token of "Authorization: Bearer TOKEN"; empty if there is none.
std::string bearer_token(std::string_view authorization);

}  // namespace gnomon::daemon::web
