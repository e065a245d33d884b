// What an operator may set, as plain data. The operator's defaults are defined here; values of the same name elsewhere
// are for tests. config/gnomond.yaml explains every key.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "common/log.h"
#include "common/result.h"
#include "common/sample_counts.h"
#include "daemon/config/config_values.h"
#include "daemon/security/tokens.h"
#include "protocol/types.h"

namespace gnomon::daemon {

enum class ServerMode : uint8_t { production, demo };

// PEM files; absolute after find_files. An empty path is not set.
struct TlsConfig {
  std::filesystem::path certificate;  // the server's own first, then intermediate ones
  std::filesystem::path key;
  std::filesystem::path client_ca;  // authorities of clients' certificates; if empty, clients are not asked for one
  std::filesystem::path client_crl = {};  // revocation lists, one of each authority; if empty, none is looked at
  friend bool operator==(const TlsConfig&, const TlsConfig&) = default;
};

struct ServerConfig {
  ServerMode mode = ServerMode::production;
  TlsConfig tls;
  std::filesystem::path state_folder;  // of files that the server makes; if empty, see demo_certificate.h
  std::string listen = "127.0.0.1";    // address of the control connections and of the data sockets
  bool insecure_listen = false;        // also where strangers reach it and need no token; see check_access
  uint16_t control_port = 7600;        // TCP; 0: a free one
  uint16_t data_port = 7600;           // UDP; net thread i has data_port + i; 0: free ones
  uint32_t net_threads = 1;
  std::chrono::milliseconds handshake_timeout{3000};  // from the connection to the Hello
  std::chrono::milliseconds silence_timeout{5000};    // then a session whose client sends nothing is closed
  std::chrono::milliseconds drain_timeout{2000};      // from SIGTERM until the remaining sessions are closed
  uint32_t max_half_open = 1024;                      // connections of clients that have not shown who they are
  uint32_t max_sessions = 2048;
  uint32_t max_sessions_per_address = 1024;
  uint32_t max_session_memory_mb = 0;       // of the host, that all sessions may need, MiB; 0: a quarter of it
  uint32_t connections_per_s = 100;         // of an address, in the long run; max_sessions_per_address in a burst
  bool require_path_validation = true;      // clients without the feature are refused
  std::chrono::seconds max_session_age{0};  // then the client has to authenticate anew; 0: no limit
  std::string public_address = {};  // numeric, where clients reach this node itself; if empty, as their door says
  std::vector<std::string> proxies = {};  // addresses and networks whose connections begin with a PROXY header
  friend bool operator==(const ServerConfig&, const ServerConfig&) = default;
};

// PEM files; absolute after find_files. An empty path is not set.
struct AdminTlsConfig {
  std::filesystem::path certificate;
  std::filesystem::path key;
  friend bool operator==(const AdminTlsConfig&, const AdminTlsConfig&) = default;
};

// Browsers as clients, on server.control_port.
struct WebConfig {
  bool listen = false;
  std::vector<std::string> hosts = {};  // further names, "node7" or "node7:443", by which browsers may reach us
  bool webtransport = false;            // beside WebSockets, on the UDP ports of the data channel
  std::chrono::milliseconds progress_timeout{15000};  // see daemon/web/progress.h
  uint32_t requests_per_s = 200;  // of an address to a net thread, in the long run; twenty times as many at once
  friend bool operator==(const WebConfig&, const WebConfig&) = default;
};

inline constexpr const char* kUsualAdminSocket = "auto";

struct AdminConfig {
  std::string listen = "127.0.0.1";
  uint16_t port = 7601;                   // HTTP; 0: a free one
  std::filesystem::path token_file = {};  // holds the token of changes over TCP; if empty, TCP changes nothing
  // Of the socket through which operators of this machine come; if empty, none; kUsualAdminSocket: see admin_socket.h.
  std::filesystem::path socket = kUsualAdminSocket;
  std::string group = {};               // its members may change things through the socket; if empty, no group's
  std::vector<std::string> hosts = {};  // further names, "node7" or "node7:443", by which browsers may reach us
  AdminTlsConfig tls = {};              // spoken off loopback; those of `server.tls` where the file names no others
  friend bool operator==(const AdminConfig&, const AdminConfig&) = default;
};

struct MovingNode {
  std::string node;                        // its name in the scene's file
  std::vector<float> spin, shift;          // exactly one is set: the axis of rotation, or the displacement
  std::chrono::milliseconds period{4000};  // of a turn, or of the displacement and return
  friend bool operator==(const MovingNode&, const MovingNode&) = default;
};

struct SceneFile {
  std::string name;
  std::filesystem::path file;  // absolute after find_files
  std::string place;           // in the configuration, for error messages
  std::vector<MovingNode> moving = {};
  friend bool operator==(const SceneFile&, const SceneFile&) = default;
};

// Where animations begin: with the daemon, with the wall clock, or by the wall clock where the node is one of a fleet.
enum class SceneClock : uint8_t { by_fleet, start, wall };

struct ScenesConfig {
  std::vector<SceneFile> list;
  std::vector<std::filesystem::path> allow_files;  // clients may ask for a glTF file below these folders
  uint32_t clock_hz = 60;                          // steps of the clock that animations play on
  SceneClock clock = SceneClock::by_fleet;
  std::filesystem::path lights_file = {};      // of lights that operators change; if empty, none
  std::chrono::milliseconds light_rest{2000};  // then the buffers of changed lights are rebuilt
  uint32_t worker_memory_mb = 8192;            // address space of the process that reads a scene, MiB
  std::chrono::seconds worker_time{120};       // its processor time
  std::chrono::seconds build_time{1800};       // that of the process that builds what traces a scene
  uint32_t max_memory_mb = 0;                  // of all scenes, MiB; 0: half of what the process may use
  friend bool operator==(const ScenesConfig&, const ScenesConfig&) = default;
};

struct RenderConfig {
  std::string device = "auto";       // "auto", a type ("cpu", "discrete", "integrated"), an index or part of a name
  std::vector<std::string> devices;  // several devices, each as `device`; if empty, `device` alone
  std::string tracer = "auto";
  std::string raster = "auto";          // "auto", "hardware", "compute"
  std::vector<std::string> passes;      // see daemon/config/render_effects.h; if empty, all effects
  std::filesystem::path cache_folder;   // for light buffers, kept for the next start; if empty, no cache
  uint32_t cache_mb = 8192;             // most that the folder may hold, MiB; 0: no limit
  uint32_t light_buffer_mb = 0;         // of a scene, for the light_buffer tracer; 0: by its lights and the device
  bool wait_for_light_buffers = false;  // before a scene is served
  uint32_t frames_in_flight = 6;
  uint32_t queues = 0;  // of the device, on which frames overlap; 0: gpu::RendererOptions
  uint16_t max_width = 3840;
  uint16_t max_height = 2160;
  uint32_t max_samples = kMostSamples;  // of an area light; 1: hard shadows alone
  Occlusion max_occlusion = Occlusion::full;
  friend bool operator==(const RenderConfig&, const RenderConfig&) = default;
};

struct EncodeConfig {
  uint32_t threads = 0;                                    // 0: by the cores, see default_encode_threads
  protocol::CodecId codec = protocol::CodecId::tiles_lz4;  // for clients that do not choose one
  friend bool operator==(const EncodeConfig&, const EncodeConfig&) = default;
};

struct SchedulerConfig {
  std::string policy = "fair";
  uint32_t priority_floor_percent = 0;  // under `priority`: of the device, for the classes below the highest
  // Frames that cost more are rendered in bands; 0: never; nullopt: by the kind of device, see SharingPolicy.
  std::optional<std::chrono::microseconds> quantum;
  uint32_t admit_percent = 1000;  // of the device: most that sessions with a rate may book together; 0: no limit
  friend bool operator==(const SchedulerConfig&, const SchedulerConfig&) = default;
};

struct TenantConfig {
  std::string name;
  uint32_t weight = 1;
  uint32_t priority = 0;
  // nullopt: as many as leave every other tenant its reserved places, see SessionLimits; 0: no limit of its own.
  std::optional<uint32_t> max_sessions = {};
  // Limits of the tenant's sessions together, or of each buffer; 0: no limit of its own.
  uint32_t max_vbps = 0;         // visibility buffers a second, of all its sessions
  uint64_t max_bits_per_s = 0;   // visibility bits: pixels x lights
  uint64_t max_bytes_per_s = 0;  // of datagrams to its clients
  uint32_t max_gpu_percent = 0;  // of the device's time
  uint16_t max_width = 0;        // of a buffer, pixels
  uint16_t max_height = 0;
  uint32_t least_rate_percent = 50;     // of what a session was granted, when the device cannot keep up
  uint32_t least_size_percent = 100;    // then, of each side of its buffer
  uint32_t least_lights_percent = 100;  // then, of the scene's lights
  uint32_t max_samples = kMostSamples;  // of an area light, 1, 4 or 16
  Occlusion max_occlusion = Occlusion::full;
  uint32_t least_samples = 1;          // after the rate, before the size, when the device cannot keep up
  uint32_t max_memory_mb = 0;          // of its sessions' buffers on the device, MiB
  uint32_t max_scene_memory_mb = 0;    // of the scenes that its clients asked for, MiB; 0: half of all scenes'
  uint32_t max_session_memory_mb = 0;  // of the host, that its sessions may need, MiB; 0: what others leave
  std::vector<TokenHash> token_sha256 = {};  // of its tokens, each of which is accepted
  bool open = false;                         // clients need no token
  // A file with more hashes of tokens; see token_files.h.
  std::filesystem::path token_sha256_file = {};
  friend bool operator==(const TenantConfig&, const TenantConfig&) = default;
};

// What a door, such as HAProxy, is told of this node; see daemon/net/door_port.h.
struct FleetConfig {
  std::string name = {};  // a domain, under which browsers come to the door; if empty, they go on as they came
  std::string door_listen = {};   // address of the door port; if empty, there is none
  uint16_t door_port = 7602;      // TCP; 0: a free one
  uint32_t assumed_rate_hz = 60;  // of sessions that named no rate, when the load is counted
  bool agones = false;            // its sidecar is told, see daemon/service/agones.h
  friend bool operator==(const FleetConfig&, const FleetConfig&) = default;
};

struct LogConfig {
  log::Level level = log::Level::info;
  log::Format format = log::Format::key_value;
  std::filesystem::path audit_file = {};  // absolute after find_files; if empty, audit lines stand among the others
};

// A client that names no tenant belongs to this one, if it is configured.
inline constexpr const char* kDefaultTenant = "default";

struct Config {
  ServerConfig server;
  WebConfig web;
  AdminConfig admin;
  ScenesConfig scenes;
  RenderConfig render;
  EncodeConfig encode;
  SchedulerConfig scheduler;
  FleetConfig fleet;
  std::vector<TenantConfig> tenants{{.name = kDefaultTenant}};  // TenantId is the index
  LogConfig log;
  ConfigValues values = {};  // what the file and the overrides say, for changes_between()
  ConfigPlaces places = {};  // and where
  std::string source = {};   // the file's name
};

// What was read, and all that is wrong with it. Keys with a mistake have their defaults.
struct ConfigReading {
  Config config;
  std::vector<Error> errors;
  std::set<std::string> mistaken = {};  // dotted keys, from whose values nothing is to be concluded

  // Whether the value of `key`, or of one above or below it, is mistaken.
  bool is_mistaken(const std::string& key) const;
};

// Reads `file`, then applies `overrides` ("key.path=value", the value in YAML) in order. Errors name file, line and
// column (or --set), the key, and what is allowed there.
ConfigReading examine_config(const std::filesystem::path& file, const std::vector<std::string>& overrides = {});

// As examine_config(), from the text of the file `name`; relative paths are kept.
ConfigReading examine_text(const std::string& text, const std::string& name,
                           const std::vector<std::string>& overrides = {});

// The same, with all errors in one, a line each.
Result<Config> read_config(const std::filesystem::path& file, const std::vector<std::string>& overrides = {});
Result<Config> parse_config(const std::string& text, const std::string& name,
                            const std::vector<std::string>& overrides = {});

// An error whose text begins with a dotted key ("server.tls.key: ..."), behind the place in the configuration where that
// key stands, or what it lies in, or else the file. As it is if it has a place already.
Error placed(const Config& config, const Error& error);

// Makes paths absolute: relative ones are below `config_folder`; scenes that are not there, below `share_folder`. Returns
// an error for each scene whose file does not exist, which names its place in the configuration and where it was searched
// for; its path is that below `config_folder`.
std::vector<Error> find_files(Config& config, const std::filesystem::path& config_folder,
                              const std::filesystem::path& share_folder);

// Error if whoever reaches server.listen from elsewhere would need no token: in demo mode, or as a tenant that is open.
// server.insecure_listen allows that.
Result<void> check_access(const ServerConfig& server, const std::vector<TenantConfig>& tenants);

// Why server.insecure_listen is needed: the error that check_access would give without it; "" if it is not.
std::string strangers_access(const ServerConfig& server, const std::vector<TenantConfig>& tenants);

// Whether the text is a numeric IP address.
bool is_address(const std::string& text);

// Error if the admin server would listen on another address than loopback without a token or without TLS.
Result<void> check_admin(const AdminConfig& admin);

bool is_loopback(const AdminConfig& admin);  // whether it listens on loopback alone

// Keys whose values differ, in full (server.tls.key).
std::vector<std::string> changed_keys(const Config& next, const Config& running);
// The dotted keys in which the two differ and that a running daemon cannot change.
std::vector<std::string> restart_keys(const Config& next, const Config& running);

// Every key that read_config knows, dotted ("server.listen", "tenants.name").
std::vector<std::string> known_keys();

}  // namespace gnomon::daemon
