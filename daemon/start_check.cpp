#include "daemon/start_check.h"

#include <sys/un.h>

#include <algorithm>

#include "common/wall_clock.h"
#include "daemon/admin/admin.h"
#include "daemon/admin/operators.h"
#include "daemon/config/render_effects.h"
#include "daemon/config/token_files.h"
#include "daemon/net/demo_certificate.h"
#include "daemon/net/listen_check.h"
#include "daemon/net/tls.h"
#include "daemon/scenes/changed_lights.h"
#include "daemon/scenes/scene_catalog.h"
#include "daemon/security/admin_socket.h"
#include "daemon/security/readable_file.h"
#include "daemon/session/credentials.h"

namespace gnomon::daemon {
namespace {

namespace fs = std::filesystem;

// Collects what is found, each with its place in the configuration.
class Findings {
 public:
  explicit Findings(const ConfigReading& reading) : reading_(reading) {}

  bool is_known(const std::string& key) const { return !reading_.is_mistaken(key); }
  // `error` begins with its key. The same is said once.
  void add(const Error& error) {
    const Error full = placed(reading_.config, error);
    const auto same = [&](const Error& other) { return other.message == full.message; };
    if (std::none_of(found_.errors.begin(), found_.errors.end(), same)) found_.errors.push_back(full);
  }
  void add(const std::string& key, const Result<void>& checked) {
    if (!checked) add(Error{key + ": " + checked.error().message});
  }
  void warn(const std::string& text) { found_.warnings.push_back(placed(reading_.config, Error{text}).message); }

  // Whether the file that a key names can be read.
  bool is_readable(const std::string& key, const fs::path& file) {
    const auto readable = check_readable(file);
    add(key, readable);
    return readable.has_value();
  }

  StartFindings take() { return std::move(found_); }

 private:
  const ConfigReading& reading_;
  StartFindings found_;
};

// A demo certificate that is there is read; else it can be made.
void check_demo_certificate(Findings& findings, const ServerConfig& server) {
  const fs::path folder = state_folder(server);
  std::error_code none;
  if (fs::exists(folder / "demo.pem", none))
    return findings.add("server.state_folder", check_readable(folder / "demo.pem"));
  findings.add("server.state_folder", check_writable_folder(folder));
}

// An expired certificate keeps no daemon from starting, nor does one that is not valid yet, as the clock of a machine that
// was just turned on may be wrong; the start logs both.
void check_dates(Findings& findings, const ServerConfig& server, const Tls& tls, bool for_start) {
  const FirstExpiry first = first_expiry(tls);
  if (first.at <= wall_now()) {
    const std::string why = std::string(first.key) + ": a certificate has expired: it is of no use to clients";
    return for_start ? findings.warn(why) : findings.add(Error{why});
  }
  const std::string why = out_of_date(server.tls.certificate, tls, wall_now());
  if (!why.empty() && !for_start) findings.add(Error{why});
}

void check_server_tls(Findings& findings, const ServerConfig& server, bool for_start) {
  if (!findings.is_known("server.tls") || !findings.is_known("server.mode")) return;
  const TlsConfig& tls = server.tls;
  bool readable = true;
  const auto look = [&](const char* key, const fs::path& file) {
    if (!file.empty()) readable &= findings.is_readable(key, file);
  };
  look("server.tls.certificate", tls.certificate);
  look("server.tls.key", tls.key);
  look("server.tls.client_ca", tls.client_ca);
  look("server.tls.client_crl", tls.client_crl);
  const bool demo = server.mode == ServerMode::demo && tls.certificate.empty() && tls.key.empty();
  if (demo) return check_demo_certificate(findings, server);
  if (!readable) return;
  const auto opened = open_tls(server);
  if (!opened) return findings.add(opened.error());
  check_dates(findings, server, **opened, for_start);
}

void check_tenants_alone(Findings& findings, const Config& config) {
  if (!findings.is_known("tenants") || !findings.is_known("server.mode")) return;
  for (const TenantConfig& tenant : config.tenants) {
    Config alone = config;
    alone.tenants = {tenant};
    if (auto reachable = check_tenants(alone); !reachable) {
      findings.add(
          Error{"tenants." + tenant.name + reachable.error().message.substr(std::string("tenants").size())});
    }
  }
}

void check_admin_server(Findings& findings, const Config& config) {
  const AdminConfig& admin = config.admin;
  if (!findings.is_known("admin")) return;
  bool readable = true;
  if (!admin.token_file.empty()) readable &= findings.is_readable("admin.token_file", admin.token_file);
  const bool own_tls =
      admin.tls.certificate != config.server.tls.certificate || admin.tls.key != config.server.tls.key;
  if (!is_loopback(admin) && own_tls && !admin.tls.certificate.empty()) {
    readable &= findings.is_readable("admin.tls.certificate", admin.tls.certificate);
    readable &= findings.is_readable("admin.tls.key", admin.tls.key);
  }
  const bool server_is_readable =
      is_loopback(admin) || own_tls || (check_readable(admin.tls.certificate) && check_readable(admin.tls.key));
  if (readable && server_is_readable && check_admin(admin)) {
    if (const auto secrets = read_admin_secrets(admin); !secrets) findings.add(secrets.error());
  }
  if (const auto group = group_of(admin.group); !group) findings.add(group.error());
  if (!admin.socket.empty() && admin.socket != kUsualAdminSocket) {
    std::error_code none;
    const fs::path folder = admin.socket.parent_path();
    if (!fs::exists(folder, none))
      return findings.add(Error{"admin.socket: " + folder.string() + ": No such file or directory"});
    if (admin.socket.string().size() >= sizeof(sockaddr_un::sun_path))
      findings.add(Error{"admin.socket: the path has " + std::to_string(admin.socket.string().size()) +
                         " bytes; allowed: " + std::to_string(sizeof(sockaddr_un::sun_path) - 1)});
    findings.add("admin.socket", check_writable_folder(folder));
  }
}

void check_scenes(Findings& findings, const ScenesConfig& scenes, const StartCheckOptions& options) {
  for (const SceneFile& scene : scenes.list) {
    const std::string named = scene.place + ": scene " + scene.name + ": ";
    const auto readable = check_readable(scene.file);
    if (!readable) {
      std::error_code none;  // what does not exist was found before
      if (fs::exists(scene.file, none)) findings.add(Error{named + readable.error().message});
      continue;
    }
    if (!options.read_scene) continue;
    const auto read = options.read_scene({scene.name, scene.file, motions_of(scene)}, {}, {});
    if (!read) findings.add(Error{named + read.error().message});
    if (read && (*read)->lights.empty()) findings.add(Error{named + kNoLights});
  }
  for (const fs::path& folder : scenes.allow_files) {
    ScenesConfig alone;
    alone.allow_files = {folder};
    const auto catalog = SceneCatalog::read(alone);
    if (!catalog) findings.add(catalog.error());
    if (catalog && !catalog->left_out().empty()) findings.warn(catalog->left_out());
  }
}

void check_folders(Findings& findings, const Config& config) {
  const fs::path& cache = config.render.cache_folder;
  if (!cache.empty()) findings.add("render.cache_folder", check_writable_folder(cache));
  const fs::path& lights = config.scenes.lights_file;
  std::error_code none;
  if (!lights.empty() && !fs::exists(lights.parent_path(), none)) {
    findings.add(Error{"scenes.lights_file: " + lights.parent_path().string() + ": No such file or directory"});
  } else if (!lights.empty()) {
    findings.add("scenes.lights_file", check_writable_folder(lights.parent_path()));
    if (const auto read = ChangedLights::read(lights); !read) findings.add("scenes.lights_file", read.error());
  }
  const fs::path& audit = config.log.audit_file;
  if (audit.empty()) return;
  if (fs::exists(audit, none)) return findings.add("log.audit_file", log::check_audit_file(audit));
  if (!fs::exists(audit.parent_path(), none)) {
    return findings.add(Error{"log.audit_file: " + audit.parent_path().string() + ": No such file or directory"});
  }
  findings.add("log.audit_file", check_writable_folder(audit.parent_path()));
}

// Deprecated since there are names of effects.
void check_passes(Findings& findings, const RenderConfig& render) {
  const auto former = renderer_passes(render);
  if (former.empty() || !findings.is_known("render.passes")) return;
  findings.warn("render.passes: '" + former.front() +
                "' is a name of before (deprecated): what clients get is named now, hard_shadows and soft_shadows");
}

// Serving nothing is no mistake in itself: scenes may come with a reload.
void check_any_scenes(Findings& findings, const ScenesConfig& scenes) {
  if (!scenes.list.empty() || !scenes.allow_files.empty() || !findings.is_known("scenes")) return;
  findings.warn("scenes.list: an empty list, and scenes.allow_files too: every client will be refused");
}

}  // namespace

StartFindings check_start(ConfigReading& reading, const StartCheckOptions& options) {
  Config& config = reading.config;
  Findings findings(reading);
  if (reading.is_mistaken("")) return findings.take();  // it could not be read at all
  for (const Error& missing : find_files(config, options.config_folder, options.share_folder))
    findings.add(missing);
  for (const Error& error : read_token_files(config)) {
    reading.errors.push_back(error);
    reading.mistaken.insert("tenants");
  }
  check_server_tls(findings, config.server, options.for_start);
  check_tenants_alone(findings, config);
  check_admin_server(findings, config);
  check_scenes(findings, config.scenes, options);
  check_any_scenes(findings, config.scenes);
  check_folders(findings, config);
  if (options.for_reload) return findings.take();
  const bool addresses_known = findings.is_known("server.listen") && findings.is_known("admin.listen");
  if (addresses_known) {
    for (const Error& error : check_listening(config)) findings.add(error);
  }
  if (options.check_renderers) {
    const std::vector<Error> errors = options.check_renderers(config);
    for (const Error& error : errors) findings.add(error);
    if (errors.empty()) check_passes(findings, config.render);
  }
  return findings.take();
}

}  // namespace gnomon::daemon
