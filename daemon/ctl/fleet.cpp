#include "daemon/ctl/fleet.h"

#include <algorithm>
#include <charconv>
#include <map>

namespace gnomon::ctl {
namespace {

constexpr uint16_t kControlPort = 7600;
// HAProxy multiplies an id by 4096 in 32 bits, so that larger ones would meet each other on its ring.
constexpr uint32_t kMostIds = 1 << 20;

struct Node {
  std::string name;
  std::string address;  // HOST:PORT
  uint32_t id = 0;
};

// From the name alone, so that it does not depend on which other nodes there are: FNV-1a, folded.
uint32_t id_of(const std::string& name) {
  uint32_t hash = 2166136261u;
  for (const char c : name) hash = (hash ^ static_cast<uint8_t>(c)) * 16777619u;
  return ((hash >> 20) ^ hash) % (kMostIds - 1) + 1;
}

bool is_word(const std::string& text, const std::string& further) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [&](char c) {
    const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    return letter || further.find(c) != std::string::npos;
  });
}

bool is_port(const std::string& text) {
  uint16_t port = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), port);
  return error == std::errc{} && end == text.data() + text.size() && port != 0;
}

// "10.0.0.11", "node7", "node7:7700", "[2001:db8::1]", "[2001:db8::1]:7700"; empty if it is none of these.
std::string with_port(const std::string& text) {
  const size_t bracket = text.find(']');
  const bool v6 = !text.empty() && text.front() == '[' && bracket != std::string::npos;
  const size_t colon = text.find(':', v6 ? bracket : 0);
  const std::string host = text.substr(0, colon);
  const std::string port = colon == std::string::npos ? std::to_string(kControlPort) : text.substr(colon + 1);
  const bool good =
      v6 ? bracket + 1 == host.size() && is_word(host.substr(1, bracket - 1), ":.") : is_word(host, "-.");
  return good && is_port(port) ? host + ":" + port : "";
}

Result<Node> node_of(const std::string& text) {
  const size_t equals = text.find('=');
  Node node{text.substr(0, equals), equals == std::string::npos ? "" : with_port(text.substr(equals + 1)), 0};
  if (!is_word(node.name, "-_.") || node.address.empty())
    return Error{"'" + text + "' is no node; allowed: NAME=HOST or NAME=HOST:PORT, such as n1=10.0.0.11"};
  node.id = id_of(node.name);
  return node;
}

Result<std::vector<Node>> nodes_of(const std::vector<std::string>& texts) {
  std::vector<Node> nodes;
  std::map<uint32_t, std::string> by_id;
  for (const std::string& text : texts) {
    auto node = node_of(text);
    if (!node) return node.error();
    const auto [other, is_new] = by_id.emplace(node->id, node->name);
    if (!is_new && other->second == node->name) return Error{"a second node named " + node->name};
    if (!is_new)
      return Error{node->name + " and " + other->second + " get the same id; call one of them otherwise"};
    nodes.push_back(std::move(*node));
  }
  return nodes;
}

// The account, the folders and the socket are those of Debian's package.
constexpr const char* kBeforeListen =
    R"(  # HAProxy opens its ports as root and serves as an account that owns nothing, where there are no files.
  user haproxy
  group haproxy
  chroot /var/lib/haproxy
  # What it makes of the nodes: echo "show stat" | socat - /run/haproxy/admin.sock
  stats socket /run/haproxy/admin.sock mode 660 level admin
  stats timeout 30s

defaults
  log global
  mode tcp
  option tcplog
  option dontlognull
  timeout connect 1s
  timeout client 30s
  timeout server 30s
  timeout tunnel 1h
  timeout check 1s

listen gnomon
  # Clients that are gone without a word are noticed, as every second something is sent to them.
)";

constexpr const char* kScenes = R"(
  # The server name says which scene is asked for (WIRE.md, Fleets). It is kept in a variable, since `balance hash` takes
  # no sample of a request's content: it would fall back to taking turns without a word.
  tcp-request inspect-delay 3s
  tcp-request content reject unless { req.ssl_hello_type 1 }
  tcp-request content set-var(sess.scene) req.ssl_sni,lower
  balance hash var(sess.scene)
  hash-type consistent sdbm avalanche
  # A full node keeps 1% of its places on the ring, and a scene whose own place comes to lie on one of them would find
  # nobody else. With a factor, nodes with far more connections than their weight asks for are passed over: those that are
  # full, unless all are. It is so large that others are not.
  hash-balance-factor 1000
  # Who was refused by a node that has just ended is sent to another one at once; without the 1 only after a second.
  option redispatch 1
  retries 2

  # A node that answers no frames is down, and its connections are cut, so that clients go elsewhere at once. One that is
  # full or drains says so itself, and keeps who is there. Weight 100, so that 1% of it is not 0.
  option httpchk GET /readyz
  http-check expect status 200
)";

}  // namespace

Result<std::string> haproxy_text(const DoorRequest& request) {
  const auto nodes = nodes_of(request.nodes);
  if (!nodes) return nodes.error();
  const std::string door = std::to_string(request.door_port);
  std::string text =
      "# The door of a fleet of gnomonds, for HAProxy 2.6 or later. Made by `gnomonctl fleet haproxy`.\n";
  text +=
      "global\n  log stdout format raw local0 notice\n  maxconn " + std::to_string(request.max_connections) + "\n";
  text += kBeforeListen;
  text += "  bind " + request.listen + " tcp-ut 20s\n";
  text += kScenes;
  text +=
      "  default-server check port " + door + " inter 500ms fall 2 rise 1 agent-check agent-port " + door +
      " agent-send \"agent\\n\" agent-inter 500ms on-marked-down shutdown-sessions send-proxy-v2 weight 100\n\n";
  text += "  # An id is made of the name, so that every door sends a scene to the same node.\n";
  for (const Node& node : *nodes)
    text += "  server " + node.name + " " + node.address + " id " + std::to_string(node.id) + "\n";
  return text;
}

}  // namespace gnomon::ctl
