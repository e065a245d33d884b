#include "daemon/config/config_keys.h"

#include <asio/ip/address.hpp>
#include <asio/ip/network_v4.hpp>
#include <asio/ip/network_v6.hpp>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "scheduler/scheduler.h"

namespace gnomon::daemon {
namespace {

using namespace schema;

constexpr int64_t kHourMs = 3'600'000;
constexpr int64_t kYearS = 31'536'000;
constexpr int64_t kMostSessions = 1'000'000;
constexpr const char* kNoLimit = " (0: no limit of its own)";
constexpr const char* kNameRule = "1 to 64 letters, digits, '_', '-' or '.'";

bool is_name(const std::string& text) {
  return !text.empty() && text.size() <= 64 && std::all_of(text.begin(), text.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-' ||
           c == '.';
  });
}

std::optional<std::string> parse_name(const YAML::Node& node) {
  auto text = any_scalar(node);
  return text && is_name(*text) ? text : std::nullopt;
}

std::optional<std::string> parse_text(const YAML::Node& node) {
  auto text = any_scalar(node);
  return text && !text->empty() ? text : std::nullopt;
}

std::optional<TokenHash> parse_hash(const YAML::Node& node) {
  const auto text = any_scalar(node);
  return text ? parse_token_hash(*text) : std::nullopt;
}

std::optional<std::filesystem::path> parse_path(const YAML::Node& node) {
  auto text = parse_text(node);
  if (!text) return std::nullopt;
  return std::filesystem::path(*text);
}

std::optional<std::filesystem::path> parse_path_or_none(const YAML::Node& node) {
  auto text = any_scalar(node);
  if (!text) return std::nullopt;
  return std::filesystem::path(*text);
}

std::optional<std::string> parse_address(const YAML::Node& node) {
  auto text = any_scalar(node);
  return text && is_address(*text) ? text : std::nullopt;
}

std::optional<std::string> parse_address_or_network(const YAML::Node& node) {
  auto text = any_scalar(node);
  if (!text || text->find('/') == std::string::npos) return parse_address(node);
  asio::error_code not_v4, not_v6;
  asio::ip::make_network_v4(*text, not_v4);
  asio::ip::make_network_v6(*text, not_v6);
  return !not_v4 || !not_v6 ? text : std::nullopt;
}

// A name that has room for that of a scene before it, in lower case as browsers have it.
std::optional<std::string> parse_domain_or_none(const YAML::Node& node) {
  constexpr size_t kMost = 253 - sizeof("s-0123456789abcdef") - sizeof('.');
  const auto text = any_scalar(node);
  if (!text || text->empty()) return text;
  const bool is_whole = text->front() != '.' && text->front() != '-' && !text->ends_with('.');
  const bool allowed = std::all_of(text->begin(), text->end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-' || c == '.';
  });
  return allowed && is_whole && text->size() <= kMost ? text : std::nullopt;
}

std::optional<std::string> parse_address_or_none(const YAML::Node& node) {
  auto text = any_scalar(node);
  return text && text->empty() ? text : parse_address(node);
}

template <class T>
Key<T> address(std::string name, std::string T::*member) {
  return scalar(std::move(name), member, "an IPv4 or IPv6 address of this machine", parse_address);
}

template <class T>
Key<T> port(std::string name, uint16_t T::*member) {
  return integer(std::move(name), member, 0, 65535, " (0: a free port)");
}

template <class T>
Key<T> name_key(std::string T::*member) {
  return scalar("name", member, kNameRule, parse_name);
}

// "auto" is read as 0.
std::optional<uint32_t> parse_threads(const YAML::Node& node) {
  if (plain_scalar(node) == "auto") return 0;
  return parse_integer<uint32_t>(node, 1, 64);
}

// "auto" is read as a nullopt quantum; the outer nullopt is an error.
std::optional<std::optional<std::chrono::microseconds>> parse_quantum(const YAML::Node& node) {
  using Quantum = std::optional<std::chrono::microseconds>;
  if (plain_scalar(node) == "auto") return Quantum();
  const auto quantum = parse_integer<std::chrono::microseconds>(node, 0, 1'000'000);
  return quantum ? std::optional<Quantum>(quantum) : std::nullopt;
}

// "auto" is read as a nullopt limit; the outer nullopt is an error.
std::optional<std::optional<uint32_t>> parse_sessions(const YAML::Node& node) {
  using Most = std::optional<uint32_t>;
  if (plain_scalar(node) == "auto") return Most();
  const auto most = parse_integer<uint32_t>(node, 0, kMostSessions);
  return most ? std::optional<Most>(most) : std::nullopt;
}

template <class S>
bool has_name(const std::vector<S>& items, const std::string& name) {
  return std::any_of(items.begin(), items.end(), [&](const S& item) { return item.name == name; });
}

std::optional<float> parse_number(const YAML::Node& node) {
  const auto text = plain_scalar(node);
  float number = 0;
  if (!text) return std::nullopt;
  const auto [end, error] = std::from_chars(text->data(), text->data() + text->size(), number);
  if (error != std::errc{} || end != text->data() + text->size() || !std::isfinite(number)) return std::nullopt;
  return number;
}

std::string finish_moving(const Value&, const std::vector<MovingNode>&, MovingNode& moving) {
  if (moving.node.empty()) return "node is needed";
  if (moving.spin.empty() == moving.shift.empty()) return "either spin or shift is needed";
  const std::vector<float>& vector = moving.spin.empty() ? moving.shift : moving.spin;
  const bool all_zero = std::all_of(vector.begin(), vector.end(), [](float v) { return v == 0; });
  return vector.size() != 3 || all_zero ? "spin and shift take three numbers that are not all 0" : "";
}

std::string finish_scene(const Value& value, const std::vector<SceneFile>& before, SceneFile& scene) {
  if (scene.name.empty() || scene.file.empty()) return "name and file are both needed";
  if (has_name(before, scene.name)) return "a second scene named " + scene.name + "; allowed: one of each name";
  scene.place = value.place() + ": " + value.path;
  return "";
}

std::string finish_tenant(const Value&, const std::vector<TenantConfig>& before, TenantConfig& tenant) {
  if (tenant.name.empty()) return "name is needed";
  if (has_name(before, tenant.name)) return "a second tenant named " + tenant.name + "; allowed: one of each name";
  return "";
}

Keys<TlsConfig> tls_keys() {
  using T = TlsConfig;
  return {
      scalar("certificate", &T::certificate, "a PEM file, or '' for none", parse_path_or_none),
      scalar("key", &T::key, "a PEM file, or '' for none", parse_path_or_none),
      scalar("client_ca", &T::client_ca, "a PEM file, or '' for none", parse_path_or_none),
      scalar("client_crl", &T::client_crl, "a PEM file, or '' for none", parse_path_or_none),
  };
}

Keys<ServerConfig> server_keys() {
  using S = ServerConfig;
  return {
      choice("mode", &S::mode, {{"production", ServerMode::production}, {"demo", ServerMode::demo}}),
      section("tls", &S::tls, tls_keys()),
      scalar("state_folder", &S::state_folder, "a folder, or '' for the usual one", parse_path_or_none),
      address("listen", &S::listen),
      choice("insecure_listen", &S::insecure_listen, {{"false", false}, {"true", true}}),
      port("control_port", &S::control_port),
      port("data_port", &S::data_port),
      integer("net_threads", &S::net_threads, 1, 64),
      integer("handshake_timeout_ms", &S::handshake_timeout, 10, kHourMs),
      integer("silence_timeout_ms", &S::silence_timeout, 100, kHourMs),
      integer("drain_timeout_ms", &S::drain_timeout, 0, kHourMs),
      integer("max_half_open", &S::max_half_open, 1, 65536),
      integer("max_sessions", &S::max_sessions, 1, kMostSessions),
      integer("max_sessions_per_address", &S::max_sessions_per_address, 1, kMostSessions),
      integer("max_session_memory_mb", &S::max_session_memory_mb, 0, 1 << 24),
      integer("connections_per_s", &S::connections_per_s, 1, 1'000'000),
      choice("require_path_validation", &S::require_path_validation, {{"false", false}, {"true", true}}),
      integer("max_session_age_s", &S::max_session_age, 0, kYearS, " (0: no limit)"),
      scalar("public_address", &S::public_address, "an IPv4 or IPv6 address, or '' for none",
             parse_address_or_none),
      scalars("proxies", &S::proxies, "a list of IPv4 or IPv6 addresses, or networks as in 10.0.0.0/8",
              parse_address_or_network),
  };
}

Keys<WebConfig> web_keys() {
  using W = WebConfig;
  return {
      choice("listen", &W::listen, {{"false", false}, {"true", true}}),
      choice("webtransport", &W::webtransport, {{"false", false}, {"true", true}}),
      scalars("hosts", &W::hosts, "a list of host names, each with or without a colon and a port", parse_text),
      integer("progress_timeout_ms", &W::progress_timeout, 100, kHourMs),
      integer("requests_per_s", &W::requests_per_s, 10, 1'000'000),
  };
}

Keys<AdminConfig> admin_keys() {
  using A = AdminConfig;
  using T = AdminTlsConfig;
  Keys<T> tls{
      scalar("certificate", &T::certificate, "a PEM file, or '' for that of server.tls", parse_path_or_none),
      scalar("key", &T::key, "a PEM file, or '' for that of server.tls", parse_path_or_none)};
  return {
      address("listen", &A::listen),
      port("port", &A::port),
      scalar("token_file", &A::token_file, "a path, or '' where TCP changes nothing", parse_path_or_none),
      scalar("socket", &A::socket, "auto, a path, or '' for none", parse_path_or_none),
      scalar("group", &A::group, "a group of this machine, or '' for none", any_scalar),
      scalars("hosts", &A::hosts, "a list of host names, each with or without a colon and a port", parse_text),
      section("tls", &A::tls, std::move(tls)),
  };
}

Keys<MovingNode> moving_keys() {
  using M = MovingNode;
  return {
      scalar("node", &M::node, "a node's name", parse_text),
      scalars("spin", &M::spin, "a list of three numbers", parse_number),
      scalars("shift", &M::shift, "a list of three numbers", parse_number),
      integer("period_ms", &M::period, 10, kHourMs),
  };
}

Keys<ScenesConfig> scenes_keys() {
  Keys<SceneFile> item{name_key(&SceneFile::name),
                       scalar("file", &SceneFile::file, "the path of a .gltf or .glb file", parse_path),
                       sections("moving", &SceneFile::moving, moving_keys(), finish_moving)};
  return {
      sections("list", &ScenesConfig::list, std::move(item), finish_scene),
      scalars("allow_files", &ScenesConfig::allow_files, "a list of folders", parse_path),
      integer("clock_hz", &ScenesConfig::clock_hz, 1, 1000),
      choice("clock", &ScenesConfig::clock,
             {{"auto", SceneClock::by_fleet}, {"start", SceneClock::start}, {"wall", SceneClock::wall}}),
      scalar("lights_file", &ScenesConfig::lights_file, "a path, or '' for none", parse_path_or_none),
      integer("light_rest_ms", &ScenesConfig::light_rest, 0, kHourMs),
      integer("worker_memory_mb", &ScenesConfig::worker_memory_mb, 256, 1 << 20),
      integer("worker_time_s", &ScenesConfig::worker_time, 1, 86'400),
      integer("build_time_s", &ScenesConfig::build_time, 1, 864'000),
      integer("max_memory_mb", &ScenesConfig::max_memory_mb, 0, 1 << 24),
  };
}

std::vector<std::pair<std::string, uint32_t>> samples() { return {{"1", 1}, {"4", 4}, {"16", 16}}; }
std::vector<std::pair<std::string, Occlusion>> occlusions() {
  return {{"none", Occlusion::none}, {"half", Occlusion::half}, {"full", Occlusion::full}};
}

Keys<RenderConfig> render_keys() {
  using R = RenderConfig;
  return {
      scalar("device", &R::device, "auto, a type (cpu, integrated, discrete), an index or part of a name",
             parse_text),
      scalars("devices", &R::devices, "a list of devices, each as render.device", parse_text),
      scalar("tracer", &R::tracer, kNameRule, parse_name),
      choice("raster", &R::raster, {{"auto", "auto"}, {"hardware", "hardware"}, {"compute", "compute"}}),
      scalars("passes", &R::passes, "a list of effects (hard_shadows, soft_shadows, ambient_occlusion)",
              parse_name),
      scalar("cache_folder", &R::cache_folder, "a folder, or '' for none", parse_path_or_none),
      integer("cache_mb", &R::cache_mb, 0, 1 << 24, " (0: no limit)"),
      integer("light_buffer_mb", &R::light_buffer_mb, 0, 1 << 20, " (0: by the number of lights and the device)"),
      choice("wait_for_light_buffers", &R::wait_for_light_buffers, {{"false", false}, {"true", true}}),
      integer("frames_in_flight", &R::frames_in_flight, 1, 16),
      integer("queues", &R::queues, 0, 16),
      integer("max_width", &R::max_width, 8, protocol::kMaxSide),
      integer("max_height", &R::max_height, 8, protocol::kMaxSide),
      choice("max_samples", &R::max_samples, samples()),
      choice("max_occlusion", &R::max_occlusion, occlusions()),
  };
}

Keys<EncodeConfig> encode_keys() {
  using protocol::CodecId;
  return {
      scalar("threads", &EncodeConfig::threads, "auto, or an integer from 1 to 64", parse_threads),
      choice("codec", &EncodeConfig::codec,
             {{"tiles_lz4", CodecId::tiles_lz4},
              {"tiles_context", CodecId::tiles_context},
              {"raw32_lz4", CodecId::raw32_lz4}}),
  };
}

Keys<FleetConfig> fleet_keys() {
  using F = FleetConfig;
  return {
      scalar("name", &F::name, "a domain in lower case, or '' for none", parse_domain_or_none),
      scalar("door_listen", &F::door_listen, "an IPv4 or IPv6 address of this machine, or '' for none",
             parse_address_or_none),
      port("door_port", &F::door_port),
      integer("assumed_rate_hz", &F::assumed_rate_hz, 1, 1000),
      choice("agones", &F::agones, {{"false", false}, {"true", true}}),
  };
}

Keys<LogConfig> log_keys() {
  using log::Format;
  using log::Level;
  return {
      choice("level", &LogConfig::level,
             {{"debug", Level::debug},
              {"info", Level::info},
              {"warning", Level::warning},
              {"error", Level::error},
              {"off", Level::off}}),
      choice("format", &LogConfig::format, {{"key_value", Format::key_value}, {"json", Format::json}}),
      scalar("audit_file", &LogConfig::audit_file, "a path, or '' for none of its own", parse_path_or_none),
  };
}

std::vector<std::pair<std::string, std::string>> policies() {
  std::vector<std::pair<std::string, std::string>> all;
  for (const std::string_view policy : scheduler::kPolicies) all.emplace_back(policy, policy);
  return all;
}

Keys<Config> all_keys() {
  const Key<SchedulerConfig> quantum =
      scalar("quantum_us", &SchedulerConfig::quantum,
             "auto, or an integer from 0 to 1000000 (0: frames are never cut)", parse_quantum);
  Keys<SchedulerConfig> scheduler{
      choice("policy", &SchedulerConfig::policy, policies()),
      integer("priority_floor_percent", &SchedulerConfig::priority_floor_percent, 0, 99),
      quantum,
      deprecated("slice_us", quantum),
      integer("admit_percent", &SchedulerConfig::admit_percent, 0, 1'000'000, " (0: no limit)"),
  };
  Keys<TenantConfig> tenant{
      name_key(&TenantConfig::name),
      integer("weight", &TenantConfig::weight, 1, 1000),
      integer("priority", &TenantConfig::priority, 0, 100),
      scalar("max_sessions", &TenantConfig::max_sessions,
             "auto, or an integer from 0 to " + std::to_string(kMostSessions) + kNoLimit, parse_sessions),
      integer("max_vbps", &TenantConfig::max_vbps, 0, 1'000'000, kNoLimit),
      integer("max_bits_per_s", &TenantConfig::max_bits_per_s, 0, int64_t{1} << 50, kNoLimit),
      integer("max_bytes_per_s", &TenantConfig::max_bytes_per_s, 0, int64_t{1} << 40, kNoLimit),
      integer("max_gpu_percent", &TenantConfig::max_gpu_percent, 0, 100, kNoLimit),
      integer("max_width", &TenantConfig::max_width, 0, protocol::kMaxSide, kNoLimit),
      integer("max_height", &TenantConfig::max_height, 0, protocol::kMaxSide, kNoLimit),
      integer("least_rate_percent", &TenantConfig::least_rate_percent, 1, 100),
      integer("least_size_percent", &TenantConfig::least_size_percent, 10, 100),
      integer("least_lights_percent", &TenantConfig::least_lights_percent, 1, 100),
      choice("max_samples", &TenantConfig::max_samples, samples()),
      choice("max_occlusion", &TenantConfig::max_occlusion, occlusions()),
      choice("least_samples", &TenantConfig::least_samples, samples()),
      integer("max_memory_mb", &TenantConfig::max_memory_mb, 0, 1 << 24, kNoLimit),
      integer("max_scene_memory_mb", &TenantConfig::max_scene_memory_mb, 0, 1 << 24),
      integer("max_session_memory_mb", &TenantConfig::max_session_memory_mb, 0, 1 << 24),
      scalars("token_sha256", &TenantConfig::token_sha256,
              "a list of SHA-256 hashes of tokens, 64 hexadecimal digits each, not the tokens, which begin with "
              "gnomon_; gnomonctl make-token makes some",
              parse_hash),
      scalar("token_sha256_file", &TenantConfig::token_sha256_file, "a file of such hashes, or '' for none",
             parse_path_or_none),
      choice("open", &TenantConfig::open, {{"true", true}, {"false", false}}),
  };
  return {
      section("server", &Config::server, server_keys()),
      section("web", &Config::web, web_keys()),
      section("admin", &Config::admin, admin_keys()),
      section("scenes", &Config::scenes, scenes_keys()),
      section("render", &Config::render, render_keys()),
      section("encode", &Config::encode, encode_keys()),
      section("scheduler", &Config::scheduler, std::move(scheduler)),
      section("fleet", &Config::fleet, fleet_keys()),
      sections("tenants", &Config::tenants, std::move(tenant), finish_tenant),
      section("log", &Config::log, log_keys()),
  };
}

}  // namespace

const schema::Keys<Config>& config_keys() {
  static const schema::Keys<Config> keys = all_keys();
  return keys;
}

}  // namespace gnomon::daemon
