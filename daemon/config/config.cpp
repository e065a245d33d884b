#include "daemon/config/config.h"

#include <algorithm>
#include <asio/ip/address.hpp>
#include <cstdlib>
#include <sstream>

#include "daemon/config/config_keys.h"
#include "daemon/config/render_effects.h"
#include "daemon/security/readable_file.h"

namespace gnomon::daemon {
namespace {

using schema::Source;
using schema::Value;

void read_into(Config& config, const YAML::Node& root, const Source& source) {
  schema::read_map(Value{source, "", root, root.Mark()}, config_keys(), config);
  add_values(config.values, root);
  add_places(config.places, root, [&](const YAML::Node& node) { return source.at(node.Mark()); });
}

// A tab where a line begins is the most frequent reason, which yaml-cpp does not name.
std::string tab_hint(const std::string& text, int line) {
  std::istringstream lines(text);
  std::string indent;
  for (int i = 0; i <= line; ++i) std::getline(lines, indent);
  indent.resize(std::min(indent.find_first_not_of(" \t"), indent.size()));
  return indent.find('\t') == std::string::npos ? "" : "; the line begins with a tab: YAML is indented with spaces";
}

// yaml-cpp throws on text that is not YAML. nullopt: the mistake is noted.
std::optional<YAML::Node> load_yaml(const std::string& text, const Source& source) {
  try {
    const std::vector<YAML::Node> documents = YAML::LoadAll(text);
    if (documents.size() <= 1) return documents.empty() ? YAML::Node() : documents.front();
    source.mistakes.errors.push_back({source.at(documents[1].Mark()) +
                                      ": a second YAML document begins, after '---'; allowed: one, with all keys"});
    return std::nullopt;
  } catch (const YAML::Exception& e) {
    const std::string hint = e.mark.is_null() ? "" : tab_hint(text, e.mark.line);
    source.mistakes.errors.push_back({source.at(e.mark) + ": not YAML: " + e.msg + hint});
    return std::nullopt;
  }
}

// "server.listen=::1" as the map {server: {listen: "::1"}}.
std::optional<YAML::Node> override_tree(const std::string& text, const Source& source) {
  const size_t equals = text.find('=');
  if (equals == 0 || equals == std::string::npos) {
    source.mistakes.errors.push_back({source.name + ": allowed: key.path=value"});
    return std::nullopt;
  }
  auto value = load_yaml(text.substr(equals + 1), source);
  if (!value) return value;
  YAML::Node tree = *value;
  std::string path = text.substr(0, equals);
  while (true) {
    const size_t dot = path.rfind('.');
    YAML::Node parent(YAML::NodeType::Map);
    parent[path.substr(dot == std::string::npos ? 0 : dot + 1)] = tree;
    tree.reset(parent);  // assignment would alias the child to its parent
    if (dot == std::string::npos) return tree;
    path.resize(dot);
  }
}

// The admin server shows the clients' certificate where it has none of its own.
void use_server_tls(Config& config) {
  AdminTlsConfig& tls = config.admin.tls;
  if (tls.certificate.empty() && tls.key.empty()) tls = {config.server.tls.certificate, config.server.tls.key};
}

// `address`: one that parsing has accepted.
bool is_loopback(const std::string& address) { return asio::ip::make_address(address).is_loopback(); }
bool is_any(const std::string& address) { return asio::ip::make_address(address).is_unspecified(); }

// Keys whose change a running daemon takes over: those of them, and those below sections. What is listed here has to be
// applied by Daemon::apply, or the reload claims to have done it.
constexpr std::string_view kReloaded[] = {"server.max_sessions",
                                          "server.max_sessions_per_address",
                                          "server.max_session_memory_mb",
                                          "server.tls",
                                          "server.insecure_listen",
                                          "admin.token_file",
                                          "admin.tls",
                                          "render.cache_mb",
                                          "scenes.list",
                                          "scenes.allow_files",
                                          "scenes.max_memory_mb",
                                          "scheduler",
                                          "tenants",
                                          "log"};

bool is_at_or_below(std::string_view key, std::string_view section) {
  return key.starts_with(section) && (key.size() == section.size() || key[section.size()] == '.');
}

template <class T>
Result<T> only_right(T value, const std::vector<Error>& errors) {
  if (errors.empty()) return value;
  std::string all;
  for (const Error& error : errors) all += (all.empty() ? "" : "\n") + error.message;
  return Error{all};
}

// Checks that involve several keys. Each is left out where one of these has a mistake of its own.
void check_together(ConfigReading& reading) {
  const Config& config = reading.config;
  const ServerConfig& server = config.server;
  const auto check = [&](const std::vector<const char*>& keys, bool wrong, const std::string& why) {
    const bool known =
        std::none_of(keys.begin(), keys.end(), [&](const char* key) { return reading.is_mistaken(key); });
    if (wrong && known) reading.errors.push_back(placed(config, Error{why}));
  };
  check({"tenants"}, config.tenants.empty(), "tenants: an empty list; allowed: at least one tenant");
  check({"server.data_port", "server.net_threads"},
        server.data_port != 0 && server.data_port + server.net_threads - 1 > 65535,
        "server.data_port: " + std::to_string(server.data_port) + " leaves no ports for " +
            std::to_string(server.net_threads) + " net threads; allowed: 0, or at most " +
            std::to_string(65536 - server.net_threads));
  check({"server.tls.client_crl", "server.tls.client_ca"},
        !server.tls.client_crl.empty() && server.tls.client_ca.empty(),
        "server.tls.client_crl: without server.tls.client_ca there is no authority that could revoke anything");
  check({"web.webtransport", "web.listen"}, config.web.webtransport && !config.web.listen,
        "web.webtransport: true, where web.listen is false; allowed: with web.listen: true, whose page uses it");
  const auto slip = misspelt_effect(config.render);
  check({"render.passes"}, slip.has_value(), slip ? "render.passes: " + *slip : "");
  const auto safe = check_access(server, config.tenants);
  check({"server.listen", "server.mode", "server.insecure_listen", "tenants"}, !safe,
        safe ? "" : safe.error().message);
  const auto admin = check_admin(config.admin);
  check({"admin", "server.tls"}, !admin, admin ? "" : admin.error().message);
  const bool same_address =
      server.listen == config.admin.listen || is_any(server.listen) || is_any(config.admin.listen);
  check({"server.listen", "server.control_port", "admin.listen", "admin.port"},
        same_address && server.control_port != 0 && server.control_port == config.admin.port,
        "admin.port: " + std::to_string(config.admin.port) +
            " is server.control_port too; allowed: another port, or 0 for a free one");
  const FleetConfig& fleet = config.fleet;
  const auto check_door = [&](const char* key, const std::string& listen, uint16_t port) {
    const bool same =
        !fleet.door_listen.empty() && (fleet.door_listen == listen || is_any(fleet.door_listen) || is_any(listen));
    check({"fleet.door_listen", "fleet.door_port", key}, same && port != 0 && port == fleet.door_port,
          "fleet.door_port: " + std::to_string(port) + " is " + key +
              " too; allowed: another port, or 0 for a free one");
  };
  check_door("server.control_port", server.listen, server.control_port);
  check_door("admin.port", config.admin.listen, config.admin.port);
}

// A path that begins with ${CREDENTIALS_DIRECTORY} lies where systemd puts what a unit's LoadCredential= names. Where it
// puts nothing, the path stays as it is, and is found missing under this name.
std::filesystem::path with_credentials(const std::filesystem::path& path) {
  constexpr std::string_view kVariable = "${CREDENTIALS_DIRECTORY}";
  const std::string text = path.string();
  const char* const folder = std::getenv("CREDENTIALS_DIRECTORY");
  if (!folder || !text.starts_with(kVariable)) return path;
  return folder + text.substr(kVariable.size());
}

std::filesystem::path absolute_below(const std::filesystem::path& folder, const std::filesystem::path& written) {
  const std::filesystem::path path = with_credentials(written);
  return std::filesystem::absolute(path.is_absolute() ? path : folder / path).lexically_normal();
}

}  // namespace

bool ConfigReading::is_mistaken(const std::string& key) const {
  return std::any_of(mistaken.begin(), mistaken.end(), [&](const std::string& other) {
    return other.empty() || is_at_or_below(key, other) || is_at_or_below(other, key);
  });
}

Error placed(const Config& config, const Error& error) {
  std::string key = error.message.substr(0, error.message.find(':'));
  const bool is_key = key.find_first_of(" /") == std::string::npos && key.find('.') != 0;
  const bool has_place = !config.source.empty() && error.message.starts_with(config.source + ":");
  if (has_place || error.message.starts_with("--set ") || !is_key) return error;
  while (!key.empty()) {
    if (const auto found = config.places.find(key); found != config.places.end()) {
      return Error{found->second + ": " + error.message};
    }
    const size_t dot = key.rfind('.');
    key.resize(dot == std::string::npos ? 0 : dot);
  }
  return config.source.empty() ? error : Error{config.source + ": " + error.message};
}

ConfigReading examine_text(const std::string& text, const std::string& name,
                           const std::vector<std::string>& overrides) {
  ConfigReading reading;
  reading.config.source = name;
  schema::Mistakes mistakes;
  const Source file{name, true, mistakes};
  if (const auto root = load_yaml(text, file)) read_into(reading.config, *root, file);
  const bool is_yaml = mistakes.errors.empty() || !mistakes.keys.empty();
  for (const std::string& text_override : overrides) {
    const Source source{"--set " + text_override, false, mistakes};
    if (const auto tree = override_tree(text_override, source)) read_into(reading.config, *tree, source);
  }
  reading.errors = std::move(mistakes.errors);
  reading.mistaken = std::move(mistakes.keys);
  if (!is_yaml) reading.mistaken.insert("");  // nothing is known
  use_server_tls(reading.config);
  check_together(reading);
  return reading;
}

ConfigReading examine_config(const std::filesystem::path& file, const std::vector<std::string>& overrides) {
  const auto text = read_file(file);
  if (!text) return {{}, {text.error()}, {""}};
  return examine_text(*text, file.string(), overrides);
}

Result<Config> parse_config(const std::string& text, const std::string& name,
                            const std::vector<std::string>& overrides) {
  ConfigReading reading = examine_text(text, name, overrides);
  return only_right(std::move(reading.config), reading.errors);
}

Result<Config> read_config(const std::filesystem::path& file, const std::vector<std::string>& overrides) {
  ConfigReading reading = examine_config(file, overrides);
  return only_right(std::move(reading.config), reading.errors);
}

std::vector<Error> find_files(Config& config, const std::filesystem::path& config_folder,
                              const std::filesystem::path& share_folder) {
  std::vector<Error> missing;
  for (SceneFile& scene : config.scenes.list) {
    const auto beside = absolute_below(config_folder, scene.file);
    const auto shared = absolute_below(share_folder, scene.file);
    std::error_code none;
    const bool is_beside = std::filesystem::exists(beside, none);
    const bool is_shared = !is_beside && std::filesystem::exists(shared, none);
    if (!is_beside && !is_shared) {
      missing.push_back(
          Error{scene.place + ": file " + scene.file.string() + " of scene " + scene.name + " does not exist" +
                (beside == shared ? "" : "; looked at " + beside.string() + " and " + shared.string())});
    }
    scene.file = is_shared ? shared : beside;
  }
  TlsConfig& tls = config.server.tls;
  AdminConfig& admin = config.admin;
  for (auto* path : {&admin.token_file, &admin.tls.certificate, &admin.tls.key, &config.render.cache_folder,
                     &config.scenes.lights_file, &config.server.state_folder, &config.log.audit_file,
                     &tls.certificate, &tls.key, &tls.client_ca, &tls.client_crl}) {
    if (!path->empty()) *path = absolute_below(config_folder, *path);
  }
  if (!admin.socket.empty() && admin.socket != kUsualAdminSocket) {
    admin.socket = absolute_below(config_folder, admin.socket);
  }
  for (TenantConfig& tenant : config.tenants) {
    auto& path = tenant.token_sha256_file;
    if (!path.empty()) path = absolute_below(config_folder, path);
  }
  for (auto& folder : config.scenes.allow_files) folder = absolute_below(config_folder, folder);
  return missing;
}

bool is_address(const std::string& text) {
  asio::error_code error;
  asio::ip::make_address(text, error);
  return !error;
}

bool is_loopback(const AdminConfig& admin) { return is_loopback(admin.listen); }

std::string strangers_access(const ServerConfig& server, const std::vector<TenantConfig>& tenants) {
  if (is_loopback(server.listen)) return "";
  const std::string reached = "server.listen: " + server.listen + " can be reached from elsewhere, and ";
  if (server.mode == ServerMode::demo) return reached + "server.mode: demo lets everybody in";
  for (const TenantConfig& tenant : tenants) {
    if (tenant.open) return reached + "tenant " + tenant.name + " is open to everybody";
  }
  return "";
}

Result<void> check_access(const ServerConfig& server, const std::vector<TenantConfig>& tenants) {
  const std::string why = strangers_access(server, tenants);
  if (why.empty() || server.insecure_listen) return {};
  return Error{
      why +
      "; allowed: a loopback address, or tenants with tokens or certificates in mode production, or, where "
      "everybody who reaches it may have frames, server.insecure_listen: true"};
}

Result<void> check_admin(const AdminConfig& admin) {
  if (admin.tls.certificate.empty() != admin.tls.key.empty()) {
    return Error{"admin.tls: certificate and key are needed together; only one of them is set"};
  }
  if (is_loopback(admin)) return {};
  const std::string elsewhere = "admin.listen: " + admin.listen + " can be reached from elsewhere; ";
  if (admin.token_file.empty()) {
    return Error{elsewhere + "allowed: a loopback address, or any with admin.token_file"};
  }
  if (admin.tls.certificate.empty()) {
    return Error{elsewhere + "its token must not cross in clear; allowed: a loopback address, or any with " +
                 "admin.tls.certificate and admin.tls.key (or those of server.tls)"};
  }
  return {};
}

std::vector<std::string> changed_keys(const Config& next, const Config& running) {
  return schema::changed_keys(config_keys(), running, next);
}

std::vector<std::string> restart_keys(const Config& next, const Config& running) {
  std::vector<std::string> keys = changed_keys(next, running);
  std::erase_if(keys, [](const std::string& key) {
    return std::any_of(std::begin(kReloaded), std::end(kReloaded),
                       [&](std::string_view reloaded) { return is_at_or_below(key, reloaded); });
  });
  return keys;
}

std::vector<std::string> known_keys() { return schema::all_paths(config_keys()); }

}  // namespace gnomon::daemon
