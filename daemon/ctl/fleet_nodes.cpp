#include "daemon/ctl/fleet_nodes.h"

#include <algorithm>
#include <fstream>
#include <future>
#include <map>
#include <sstream>

#include "daemon/ctl/status_members.h"

namespace gnomon::ctl {
namespace {

using nlohmann::json;

Result<void> add(std::vector<FleetNode>& nodes, FleetNode node) {
  const auto address = parse_admin_address(node.address);
  if (!address) return Error{node.name + ": " + address.error().message};
  if (std::ranges::any_of(nodes, [&](const FleetNode& other) { return other.name == node.name; })) {
    return Error{"a second node named " + node.name};
  }
  nodes.push_back(std::move(node));
  return {};
}

Result<std::vector<FleetNode>> named_nodes(const std::string& text) {
  std::vector<FleetNode> nodes;
  std::istringstream words(text);
  for (std::string word; std::getline(words, word, ',');) {
    const size_t equals = word.find('=');
    if (equals == 0 || equals == std::string::npos) {
      return Error{"'" + word + "' is no node; allowed: NAME=ADDRESS, such as n1=https://10.0.0.11:7601"};
    }
    if (auto added = add(nodes, {word.substr(0, equals), word.substr(equals + 1)}); !added) return added.error();
  }
  return nodes;
}

Result<std::vector<FleetNode>> listed_nodes(const std::string& path) {
  std::ifstream file(path);
  if (!file) return Error{path + ": cannot be read"};
  std::vector<FleetNode> nodes;
  int number = 0;
  for (std::string line; std::getline(file, line);) {
    ++number;
    std::istringstream words(line.substr(0, line.find('#')));
    FleetNode node;
    std::string more;
    if (!(words >> node.name)) continue;
    const std::string where = path + ":" + std::to_string(number) + ": ";
    if (!(words >> node.address) || words >> more) return Error{where + "allowed: NAME ADDRESS"};
    if (auto added = add(nodes, std::move(node)); !added) return Error{where + added.error().message};
  }
  if (nodes.empty()) return Error{path + ": it names no node"};
  return nodes;
}

// Calls `ask` for every node on threads of their own, as one that is gone takes seconds to say so.
template <class Answer, class Ask>
std::vector<Answer> asked_at_once(const std::vector<FleetNode>& nodes, const AdminAccess& access, Ask ask) {
  std::vector<std::future<Answer>> pending;
  for (const FleetNode& node : nodes) {
    pending.push_back(std::async(std::launch::async, [node, access, &ask] {
      AdminClient client({node.address, access.token, access.authority, access.name});
      return Answer{node.name, ask(client)};
    }));
  }
  std::vector<Answer> answers;
  for (auto& each : pending) answers.push_back(each.get());
  return answers;
}

// What is booked of the devices that take sessions.
double load_of(const json& status) {
  double booked = 0, in_service = 0;
  for (const json& device : list(status, "devices")) {
    booked += number(device, "load");
    in_service += device.value("up", false) && !device.value("drained", false);
  }
  return in_service > 0 ? booked / in_service : 0;
}

}  // namespace

bool nodes_are_named(const std::string& text) { return text.find('=') != std::string::npos; }

Result<std::vector<FleetNode>> fleet_nodes(const std::string& text) {
  return nodes_are_named(text) ? named_nodes(text) : listed_nodes(text);
}

Result<FleetNode> node_named(const std::vector<FleetNode>& nodes, const std::string& name) {
  std::string known;
  for (const FleetNode& node : nodes) {
    if (node.name == name) return node;
    known += (known.empty() ? "" : ", ") + node.name;
  }
  return Error{(name.empty() ? "of a fleet one node is named (--node)" : "no node " + name) +
               "; there are: " + known};
}

std::vector<NodeStatus> status_of(const std::vector<FleetNode>& nodes, const AdminAccess& access) {
  return asked_at_once<NodeStatus>(nodes, access, [](AdminClient& client) { return client.status(); });
}

std::vector<NodeStatus> lights_of(const std::vector<FleetNode>& nodes, const AdminAccess& access) {
  return asked_at_once<NodeStatus>(nodes, access, [](AdminClient& client) { return client.get("/lights"); });
}

json newest_lights(const std::vector<json>& tables) {
  std::map<std::pair<std::string, double>, json> newest;
  for (const json& table : tables) {
    for (const json& light : list(table, "lights")) {
      json& known = newest[{light.value("scene", ""), number(light, "light")}];
      if (known.is_null() || number(light, "at_ms") > number(known, "at_ms")) known = light;
    }
  }
  json lights = json::array();
  for (auto& [place, light] : newest) lights.push_back(std::move(light));
  return {{"lights", std::move(lights)}};
}

std::vector<NodeAnswer> post_to(const std::vector<FleetNode>& nodes, const AdminAccess& access,
                                const std::string& path, const json& body) {
  return asked_at_once<NodeAnswer>(nodes, access, [&](AdminClient& client) { return client.post(path, body); });
}

std::string fleet_text(const std::vector<NodeStatus>& fleet) {
  Table table({"NODE", "STATE", ">SESSIONS", ">LOAD", ">SCENES", "VERSION"});
  for (const NodeStatus& node : fleet) {
    if (!node.status) {
      table.add({without_controls(node.name), "does not answer", "", "", "", ""});
      continue;
    }
    const json& status = *node.status;
    table.add({without_controls(node.name), state_of(status), std::to_string(list(status, "sessions").size()),
               percent(load_of(status)), std::to_string(list(status, "scenes").size()), text(status, "version")});
  }
  return table.text();
}

json fleet_json(const std::vector<NodeStatus>& fleet) {
  json all = json::array();
  for (const NodeStatus& node : fleet) {
    json one{{"node", node.name}};
    if (node.status) {
      one["status"] = *node.status;
    } else {
      one["error"] = node.status.error().message;
    }
    all.push_back(std::move(one));
  }
  return all;
}

}  // namespace gnomon::ctl
