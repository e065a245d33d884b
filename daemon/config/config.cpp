#include "daemon/config/config.h"

#include <asio/ip/address.hpp>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "daemon/config/config_keys.h"

namespace gnomon::daemon {
namespace {

using schema::Source;
using schema::Value;

Result<void> read_into(Config& config, const YAML::Node& root, const Source& source) {
  return schema::read_map(Value{source, "", root, root.Mark()}, config_keys(), config);
}

// yaml-cpp throws on text that is not YAML.
Result<YAML::Node> load_yaml(const std::string& text, const Source& source) {
  try {
    return YAML::Load(text);
  } catch (const YAML::Exception& e) {
    const std::string line = source.has_lines ? ":" + std::to_string(e.mark.line + 1) : "";
    return Error{source.name + line + ": not YAML: " + e.msg};
  }
}

// "server.listen=::1" as the map {server: {listen: "::1"}}.
Result<YAML::Node> override_tree(const std::string& text, const Source& source) {
  const size_t equals = text.find('=');
  if (equals == 0 || equals == std::string::npos) return Error{source.name + ": allowed: key.path=value"};
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

// Checks that involve several keys.
Result<void> check_together(const Config& config) {
  const ServerConfig& server = config.server;
  if (config.tenants.empty()) return Error{"tenants: an empty list; allowed: at least one tenant"};
  if (server.data_port != 0 && server.data_port + server.net_threads - 1 > 65535) {
    return Error{"server.data_port: " + std::to_string(server.data_port) + " leaves no ports for " +
                 std::to_string(server.net_threads) + " net threads; allowed: 0, or at most " +
                 std::to_string(65536 - server.net_threads)};
  }
  if (!server.tls.client_crl.empty() && server.tls.client_ca.empty()) {
    return Error{
        "server.tls.client_crl: without server.tls.client_ca there is no authority that could revoke anything"};
  }
  if (auto safe = check_access(server, config.tenants); !safe) return safe;
  return check_admin(config.admin);
}

Result<std::string> read_file(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream text;
  if (!stream || !(text << stream.rdbuf())) return Error{file.string() + ": cannot be read"};
  return std::move(text).str();
}

// `address`: one that parsing has accepted.
bool is_loopback(const std::string& address) { return asio::ip::make_address(address).is_loopback(); }

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

Result<Config> parse_config(const std::string& text, const std::string& name,
                            const std::vector<std::string>& overrides) {
  Config config;
  const Source file{name, true};
  auto root = load_yaml(text, file);
  if (!root) return root.error();
  if (auto read = read_into(config, *root, file); !read) return read.error();
  add_values(config.values, *root);
  for (const std::string& text_override : overrides) {
    const Source source{"--set " + text_override, false};
    auto tree = override_tree(text_override, source);
    if (!tree) return tree.error();
    if (auto read = read_into(config, *tree, source); !read) return read.error();
    add_values(config.values, *tree);
  }
  use_server_tls(config);
  if (auto fits = check_together(config); !fits) return Error{name + ": " + fits.error().message};
  return config;
}

Result<Config> read_config(const std::filesystem::path& file, const std::vector<std::string>& overrides) {
  auto text = read_file(file);
  if (!text) return text.error();
  return parse_config(*text, file.string(), overrides);
}

std::vector<Error> find_files(Config& config, const std::filesystem::path& config_folder,
                              const std::filesystem::path& share_folder) {
  std::vector<Error> missing;
  for (SceneFile& scene : config.scenes.list) {
    const auto beside = absolute_below(config_folder, scene.file);
    const auto shared = absolute_below(share_folder, scene.file);
    std::error_code none;
    const bool is_beside = std::filesystem::is_regular_file(beside, none);
    const bool is_shared = !is_beside && std::filesystem::is_regular_file(shared, none);
    if (!is_beside && !is_shared) {
      missing.push_back(Error{scene.place + ": file " + scene.file.string() + " of scene " + scene.name +
                              " does not exist; looked at " + beside.string() + " and " + shared.string()});
    }
    scene.file = is_shared ? shared : beside;
  }
  TlsConfig& tls = config.server.tls;
  AdminConfig& admin = config.admin;
  for (auto* path : {&admin.token_file, &admin.tls.certificate, &admin.tls.key, &config.render.cache_folder,
                     &config.server.state_folder, &config.log.audit_file, &tls.certificate, &tls.key,
                     &tls.client_ca, &tls.client_crl}) {
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

bool needs_restart(const Config& next, const Config& running) {
  ServerConfig server = next.server;
  server.max_sessions = running.server.max_sessions;
  server.max_sessions_per_address = running.server.max_sessions_per_address;
  server.max_session_memory_mb = running.server.max_session_memory_mb;
  server.tls = running.server.tls;
  server.insecure_listen = running.server.insecure_listen;
  AdminConfig admin = next.admin;
  admin.token_file = running.admin.token_file;
  admin.tls = running.admin.tls;
  ScenesConfig scenes = next.scenes;
  scenes.max_memory_mb = running.scenes.max_memory_mb;
  return server != running.server || admin != running.admin || scenes != running.scenes ||
         next.render != running.render || next.encode != running.encode || next.log.format != running.log.format;
}

std::vector<std::string> known_keys() { return schema::all_paths(config_keys()); }

}  // namespace gnomon::daemon
