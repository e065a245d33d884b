#include "daemon/ctl/init.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <istream>
#include <ostream>
#include <sstream>

#include "daemon/config/config.h"
#include "daemon/ctl/init_config.h"
#include "daemon/ctl/new_file.h"
#include "daemon/ctl/secrets.h"
#include "daemon/security/tokens.h"

namespace gnomon::ctl {
namespace {

namespace fs = std::filesystem;

const fs::path kPackaged = "/etc/gnomon";
const fs::path kUnits = "/etc/systemd/system";
constexpr std::array<const char*, 2> kBuiltIn = {"living_room", "temple"};
// The packaged unit does not let the daemon see them (ProtectHome, PrivateTmp).
constexpr std::array<const char*, 5> kHidden = {"/home/", "/root/", "/run/user/", "/tmp/", "/var/tmp/"};

// The letters of names, IPv4 and IPv6 addresses.
bool is_host(const std::string& text) {
  return !text.empty() &&
         text.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789.-_:*") ==
             std::string::npos;
}

bool is_plain_name(const std::string& name) {
  const auto plain = [](unsigned char c) { return std::isalnum(c) != 0 || c == '_' || c == '-' || c == '.'; };
  return !name.empty() && name.front() != '.' && std::all_of(name.begin(), name.end(), plain);
}

Result<SceneEntry> scene_entry(const std::string& text) {
  if (is_built_in(text)) return SceneEntry{text, text + ".glb"};
  const size_t equals = text.find('=');
  const fs::path given = equals == std::string::npos ? text : text.substr(equals + 1);
  std::error_code error;
  const fs::path file = fs::absolute(given, error).lexically_normal();
  if (given.empty() || !fs::is_regular_file(file, error)) {
    return Error{"--scene " + text + ": " + (given.empty() ? "no file" : file.string() + " is no file") +
                 "; allowed: living_room, temple, NAME=FILE or FILE"};
  }
  const std::string name = equals == std::string::npos ? file.stem().string() : text.substr(0, equals);
  if (!is_plain_name(name)) return Error{"--scene " + text + ": '" + name + "' is no name for a scene"};
  return SceneEntry{name, file.string()};
}

class Installation {
 public:
  explicit Installation(const InitRequest& request) : request_(request) {}

  Result<void> check() {
    if (auto understood = check_init(request_); !understood) return understood;
    for (const std::string& text : request_.scenes) scenes_.push_back(*scene_entry(text));
    if (fs::exists(private_folder() / "ca.pem") && !fs::exists(private_folder() / "ca-key.pem")) {
      return Error{(private_folder() / "ca.pem").string() +
                   " is there and ca-key.pem beside it is not: put it back, or "
                   "move ca.pem away, so that a new authority is made, which all clients then need"};
    }
    auto text = config_text(request_, scenes_, packaged() ? "/var/cache/gnomon" : "cache");
    if (!text) return text.error();
    config_ = std::move(*text);
    for_restart_ = keys_for_restart(request_.out, config_);
    return {};
  }

  Result<void> write() {
    for (const fs::path& folder : {credentials(), private_folder(), private_folder() / "clients"}) {
      std::error_code error;
      if (fs::create_directories(folder, error)) fs::permissions(folder, fs::perms::owner_all, error);
      if (error) return Error{folder.string() + ": " + error.message()};
    }
    if (auto done = write_certificates(); !done) return done;
    for (const std::string& tenant : request_.tenants) {
      if (auto done = write_tenant(tenant); !done) return done;
    }
    if (auto done = write_config(); !done) return done;
    return write_drop_in();
  }

  std::string next_steps() const;

 private:
  fs::path credentials() const { return request_.out / "credentials"; }
  fs::path private_folder() const { return request_.out / "private"; }
  fs::path config() const { return request_.out / "gnomond.yaml"; }
  fs::path client_folder(const std::string& tenant) const { return private_folder() / "clients" / tenant; }
  bool packaged() const { return request_.out.lexically_normal() == kPackaged; }
  fs::path drop_in() const {
    const fs::path units = !request_.systemd.empty() ? request_.systemd
                           : packaged()              ? kUnits
                                                     : request_.out / "systemd";
    return units / "gnomond.socket.d" / "gnomon.conf";
  }
  std::string reached_at() const {
    const std::string& host = request_.hosts.front();
    const bool v6 = host.find(':') != std::string::npos;
    return (v6 ? "[" + host + "]" : host) + ":" + std::to_string(request_.port);
  }
  bool serves_browsers() const { return request_.browsers.value_or(false); }
  std::string words_about_the_start() const;
  std::string words_about_the_fleet() const;
  std::string words_about_browsers() const;
  // What the daemon reads is root's, and where the folder has a group of its own, that group's too.
  mode_t credential_mode() const { return geteuid() == 0 ? 0640 : 0600; }

  Result<void> write_certificates();
  Result<void> write_tenant(const std::string& tenant);
  Result<void> write_config();
  Result<void> write_drop_in();

  const InitRequest& request_;
  std::vector<SceneEntry> scenes_;
  std::string config_;                                   // what is to be written
  std::optional<std::vector<std::string>> for_restart_;  // keys_for_restart()
  bool new_drop_in_ = false;
};

Result<void> Installation::write_certificates() {
  const fs::path made = private_folder();
  CertsRequest certs{.out = made,
                     .hosts = request_.hosts,
                     .fleet = request_.fleet,
                     .tenants = {},
                     .days = request_.days,
                     .renew = true};
  if (const auto done = make_certs(certs); !done) return done.error();
  for (const char* name : {"server.pem", "server-key.pem"}) {
    const std::string pem = read_file(made / name);
    std::error_code ignored;
    fs::remove(made / name, ignored);
    if (auto done = write_file(credentials() / name, pem, credential_mode()); !done) return done;
  }
  return {};
}

Result<void> Installation::write_tenant(const std::string& tenant) {
  const fs::path folder = client_folder(tenant);
  std::error_code error;
  fs::create_directories(folder, error);
  fs::permissions(folder, fs::perms::owner_all, error);
  if (error) return Error{folder.string() + ": " + error.message()};
  std::string token = read_file(folder / "token");
  token.resize(std::min(token.find('\n'), token.size()));
  if (token.empty()) token = daemon::make_token();
  if (auto done = write_file(folder / "token", token + "\n", 0600); !done) return done;
  if (auto done = write_file(folder / "ca.pem", read_file(private_folder() / "ca.pem"), 0644); !done) return done;
  const std::string hash = daemon::to_hex(daemon::hash_of(token)) + "\n";
  return write_file(credentials() / (tenant + ".sha256"), hash, credential_mode());
}

Result<void> Installation::write_config() {
  const std::string before = read_file(config());
  if (!before.empty() && before != config_) {
    if (auto kept = write_file(config().string() + ".before", before, 0644); !kept) return kept;
  }
  return write_file(config(), config_, 0644);
}

Result<void> Installation::write_drop_in() {
  std::error_code error;
  fs::create_directories(drop_in().parent_path(), error);
  if (error) return Error{drop_in().parent_path().string() + ": " + error.message()};
  const bool v6 = request_.listen.find(':') != std::string::npos;
  const std::string address =
      (v6 ? "[" + request_.listen + "]" : request_.listen) + ":" + std::to_string(request_.port);
  const std::string text =
      "# Written by `gnomonctl init`: as server.listen and the ports in gnomond.yaml.\n[Socket]\n"
      "ListenStream=\nListenDatagram=\nListenStream=" +
      address + "\nListenDatagram=" + address + "\n";
  new_drop_in_ = read_file(drop_in()) != text;
  return write_file(drop_in(), text, 0644);
}

// What a daemon needs that may run with what was written before.
std::string Installation::words_about_the_start() const {
  const std::string by_hand = "     gnomond --config " + config().string() + "\n";
  if (!for_restart_ || new_drop_in_) {
    // Not `restart`: systemd starts no socket whose service is still active.
    return "1. Start it with what was written:\n" +
           (packaged()
                ? "     systemctl daemon-reload && systemctl stop gnomond.service gnomond.socket && systemctl "
                  "start gnomond.socket gnomond.service\n"
                : by_hand);
  }
  if (for_restart_->empty()) {
    return "1. A daemon that runs takes what was written by a reload, which drops no session:\n     gnomonctl "
           "reload\n"
           "   One that does not run is started:\n" +
           (packaged() ? "     systemctl start gnomond.socket gnomond.service\n" : by_hand);
  }
  std::string keys;
  for (const std::string& key : *for_restart_) keys += (keys.empty() ? "" : ", ") + key;
  return "1. Restart it, as a reload does not change " + keys + ":\n" +
         (packaged() ? "     systemctl restart gnomond.service\n" : by_hand);
}

std::string Installation::words_about_browsers() const {
  if (!serves_browsers()) {
    return "Browsers are not served; `web: {listen: true}` in " + config().string() +
           ", or --browsers here, turns the viewer on.\n";
  }
  return "   A browser opens the scene, once it trusts the folder's ca.pem as an authority, at\n     https://" +
         reached_at() + "/#scene=" + scenes_.front().name + "&tenant=" + request_.tenants.front() +
         "\n   and asks for the token, which stays in that tab.\n";
}

// Of the other nodes and the doors.
std::string Installation::words_about_the_fleet() const {
  if (request_.fleet.empty()) return "";
  return "5. Another node has the same files in " + request_.out.string() + " but for private, and " +
         drop_in().string() + "; its own address takes the place of " + request_.public_address + " in " +
         config().string() + ".\n   The doors' configuration is written by `gnomonctl fleet haproxy`.\n";
}

std::string Installation::next_steps() const {
  const std::string port = std::to_string(request_.port);
  const std::string checks = "gnomond --config " + config().string() + " --check-config";
  std::ostringstream text;
  text << "Written: " << config().string() << ", " << credentials().string() << ", " << private_folder().string()
       << ", " << drop_in().string() << "\n\nNext:\n\n"
       << words_about_the_start();
  text << "   `" << checks << "` says what is wrong, if something is.\n"
       << "2. Let TCP and UDP port " << port << " through the firewall.\n"
       << "3. Hand each tenant its folder, over a way that nobody else reads, and the files of the scenes:\n";
  for (const std::string& tenant : request_.tenants) {
    text << "     " << client_folder(tenant).string() << "\n";
  }
  text
      << "   Within it, a client is started with\n     gnomon-client --server " << reached_at()
      << (request_.fleet.empty() ? "" : " --fleet " + request_.fleet) << " --ca ca.pem --tenant "
      << request_.tenants.front() << " --token-file token --scene " << scenes_.front().name << " --size 960x540\n"
      << (serves_browsers() ? words_about_browsers() : "") << "4. Move "
      << (private_folder() / "ca-key.pem").string()
      << " off this machine: it makes certificates for anybody. `gnomonctl init` needs it there to make another one"
      << " before " << request_.days << " days are over.\n"
      << words_about_the_fleet() << (serves_browsers() ? "" : "\n" + words_about_browsers());
  for (const SceneEntry& scene : scenes_) {
    for (const char* hidden : kHidden) {
      if (packaged() && scene.file.starts_with(hidden)) {
        text << "\nNote: the packaged unit hides " << hidden << " from the daemon; move " << scene.file
             << " elsewhere, for example to /srv, and say so in " << config().string() << ".\n";
      }
    }
  }
  return text.str();
}

std::vector<std::string> words_of(const std::string& line) {
  std::istringstream words(line);
  std::vector<std::string> all;
  for (std::string word; words >> word;) all.push_back(word);
  return all;
}

std::string host_name() {
  std::array<char, 256> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "localhost";
}

void ask(std::vector<std::string>& answer, const std::string& question, const std::string& proposed,
         std::istream& in, std::ostream& out) {
  if (!answer.empty()) return;
  out << question << " [" << proposed << "]: " << std::flush;
  std::string line;
  std::getline(in, line);
  answer = words_of(line);
  if (answer.empty()) answer = words_of(proposed);
}

constexpr const char* kEveryAddress = "0.0.0.0";
constexpr uint16_t kClientsPort = 7600;

}  // namespace

bool is_built_in(const std::string& scene) {
  return std::find(kBuiltIn.begin(), kBuiltIn.end(), scene) != kBuiltIn.end();
}

void ask_for_missing(InitRequest& request, std::istream& in, std::ostream& out) {
  if (request.hosts.empty() && !request.fleet.empty()) request.hosts = {request.fleet};
  ask(request.hosts, "Names and addresses by which clients reach this machine", host_name(), in, out);
  ask(request.tenants, "Tenants, whose clients are served", "default", in, out);
  ask(request.scenes, "Scenes: living_room, temple, NAME=FILE or FILE", "living_room temple", in, out);
  if (request.port == 0) request.port = kClientsPort;
  if (request.browsers) return;
  std::vector<std::string> answer;
  ask(answer,
      "Serve browsers too, at https://" + request.hosts.front() + ":" + std::to_string(request.port) +
          "/ (yes, no)",
      "no", in, out);
  request.browsers = answer.front() == "yes" || answer.front() == "y";
}

Result<void> check_init(const InitRequest& request) {
  if (request.hosts.empty() && request.fleet.empty())
    return Error{"--host is missing: the names and addresses by which clients reach it"};
  if (!request.fleet.empty() && request.public_address.empty())
    return Error{"--public-address is missing: where clients of a node of a fleet send their datagrams"};
  if (!request.fleet.empty() && request.proxies.empty())
    return Error{"--proxies is missing: the addresses of the fleet's doors"};
  for (const std::string& host : request.hosts) {
    if (!is_host(host)) return Error{"--host " + host + ": a name or an address is needed"};
  }
  const std::pair<const char*, const std::string&> addresses[] = {{"--listen", request.listen},
                                                                  {"--public-address", request.public_address},
                                                                  {"--door-listen", request.door_listen}};
  for (const auto& [option, text] : addresses) {
    if (!text.empty() && !daemon::is_address(text))
      return Error{std::string(option) + " " + text + ": an IP address is needed"};
  }
  for (const std::string& tenant : request.tenants) {
    if (!is_plain_name(tenant)) return Error{"--tenant " + tenant + ": allowed: letters, digits, '_', '-' and '.'"};
  }
  for (const std::string& text : request.scenes) {
    if (const auto entry = scene_entry(text); !entry) return entry.error();
  }
  return {};
}

Result<std::string> init(const InitRequest& asked) {
  InitRequest request = asked;
  std::error_code error;
  request.out = fs::absolute(request.out, error).lexically_normal();
  if (auto taken = take_from_before(request); !taken) return taken.error();
  if (request.hosts.empty() && !request.fleet.empty()) request.hosts = {request.fleet};
  if (request.listen.empty()) request.listen = kEveryAddress;
  if (request.port == 0) request.port = kClientsPort;
  if (request.door_listen.empty()) request.door_listen = request.public_address;
  if (request.tenants.empty()) request.tenants = {"default"};
  if (request.scenes.empty()) request.scenes.assign(kBuiltIn.begin(), kBuiltIn.end());
  Installation installation(request);
  if (auto possible = installation.check(); !possible) return possible.error();
  if (auto written = installation.write(); !written) return written.error();
  return installation.next_steps();
}

}  // namespace gnomon::ctl
