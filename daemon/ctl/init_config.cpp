#include "daemon/ctl/init_config.h"

#include <nlohmann/json.hpp>

#include "daemon/config/config.h"
#include "daemon/config/edited_config.h"
#include "daemon/ctl/new_file.h"

namespace gnomon::ctl {
namespace {

namespace fs = std::filesystem;
using daemon::EditedConfig;

// How a file begins that `init` has written. Others, such as the package's with every default, are not taken over.
constexpr const char* kBegins = "# Written by `gnomonctl init`.";
constexpr const char* kHeader = " gnomond.yaml(5) explains every key, those that are not here too.\n";
constexpr const char* kFleetDrainMs = "40000";  // so that a scene can be loaded elsewhere (docs/fleet.md, Moving)

// A text in quotes, as JSON and YAML both read it.
std::string quoted(const std::string& text) { return nlohmann::json(text).dump(); }

fs::path config_file(const fs::path& folder) { return folder / "gnomond.yaml"; }

// Without keys if there is none of ours.
Result<EditedConfig> before(const fs::path& folder) {
  const std::string text = read_file(config_file(folder));
  auto read = EditedConfig::read(text.starts_with(kBegins) ? text : "");
  if (!read) return Error{config_file(folder).string() + ": " + read.error().message};
  return read;
}

void take(std::string& said, const EditedConfig& config, const std::string& key) {
  if (said.empty()) said = config.text(key);
}

std::vector<std::string> scenes_of(const EditedConfig& config, const fs::path& folder) {
  const auto names = config.texts("scenes.list", "name"), files = config.texts("scenes.list", "file");
  std::vector<std::string> scenes;
  for (size_t i = 0; i < names.size(); ++i) {
    const bool built_in = is_built_in(names[i]) && files[i] == names[i] + ".glb";
    scenes.push_back(built_in ? names[i] : names[i] + "=" + (folder / files[i]).string());
  }
  return scenes;
}

void set_fleet(EditedConfig& config, const InitRequest& request) {
  if (request.fleet.empty()) return;
  config.set("server.public_address", quoted(request.public_address));
  config.set("server.proxies", nlohmann::json(request.proxies).dump());
  if (!config.has("server.drain_timeout_ms")) config.set("server.drain_timeout_ms", kFleetDrainMs);
  config.set("fleet.name", quoted(request.fleet));
  config.set("fleet.door_listen", quoted(request.door_listen));
  if (request.door_port != 0) config.set("fleet.door_port", std::to_string(request.door_port));
}

}  // namespace

Result<void> take_from_before(InitRequest& request) {
  const auto config = before(request.out);
  if (!config) return config.error();
  if (request.tenants.empty()) request.tenants = config->texts("tenants", "name");
  if (request.scenes.empty()) request.scenes = scenes_of(*config, request.out);
  take(request.listen, *config, "server.listen");
  const std::string port = config->text("server.control_port");
  if (request.port == 0 && !port.empty()) request.port = static_cast<uint16_t>(std::atoi(port.c_str()));
  if (!request.browsers && config->has("server")) request.browsers = config->text("web.listen") == "true";
  take(request.fleet, *config, "fleet.name");
  take(request.public_address, *config, "server.public_address");
  if (request.proxies.empty()) request.proxies = config->texts("server.proxies");
  take(request.door_listen, *config, "fleet.door_listen");
  return {};
}

Result<std::string> config_text(const InitRequest& request, const std::vector<SceneEntry>& scenes,
                                const fs::path& cache_folder) {
  auto config = before(request.out);
  if (!config) return config.error();
  config->set("server.mode", "production");
  config->set("server.listen", quoted(request.listen));
  config->set("server.control_port", std::to_string(request.port));
  config->set("server.data_port", std::to_string(request.port));
  config->set("server.tls.certificate", "credentials/server.pem");
  config->set("server.tls.key", "credentials/server-key.pem");
  if (!config->has("render.cache_folder")) config->set("render.cache_folder", quoted(cache_folder.string()));
  nlohmann::ordered_json list = nlohmann::ordered_json::array(), tenants = list;
  for (const SceneEntry& scene : scenes) list.push_back({{"name", scene.name}, {"file", scene.file}});
  config->set("scenes.list", list.dump());
  const bool browsers = request.browsers.value_or(false);
  if (browsers || config->has("web.listen")) config->set("web.listen", browsers ? "true" : "false");
  set_fleet(*config, request);
  for (const std::string& name : request.tenants)
    tenants.push_back({{"name", name}, {"token_sha256_file", "credentials/" + name + ".sha256"}});
  config->set("tenants", tenants.dump());
  std::string text = std::string(kBegins) + kHeader + config->written();
  if (const auto read = daemon::parse_config(text, config_file(request.out).string()); !read) return read.error();
  return text;
}

std::optional<std::vector<std::string>> keys_for_restart(const fs::path& folder, const std::string& text) {
  const std::string name = config_file(folder).string(), text_before = read_file(config_file(folder));
  if (!text_before.starts_with(kBegins)) return std::nullopt;
  const auto running = daemon::parse_config(text_before, name), next = daemon::parse_config(text, name);
  if (!running || !next) return std::nullopt;  // no daemon runs with a configuration that cannot be read
  return daemon::restart_keys(*next, *running);
}

}  // namespace gnomon::ctl
