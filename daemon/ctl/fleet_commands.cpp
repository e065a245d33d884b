#include "daemon/ctl/fleet_commands.h"

#include <sys/stat.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <utility>

#include "daemon/ctl/fleet_nodes.h"
#include "daemon/ctl/new_file.h"
#include "daemon/ctl/status_members.h"

namespace gnomon::ctl {
namespace {

using nlohmann::json;

constexpr mode_t kLightsMode = 0600;  // of a file that the daemon's account has to itself

constexpr size_t kPieceBytes =
    3000;  // of what is posted at once; the admin server takes 4096 (http_connection.cpp)

struct Fleet {
  std::vector<FleetNode> nodes;
  AdminAccess access;
};

Result<Fleet> fleet_of(Arguments& arguments) {
  auto nodes = fleet_nodes(arguments.fleet);
  if (!nodes && nodes_are_named(arguments.fleet)) return wrong_usage(arguments, nodes.error());
  if (!nodes) return nodes.error();
  auto access = access_of(arguments);
  if (!access) return access.error();
  return Fleet{std::move(*nodes), std::move(*access)};
}

Result<void> all_answered(const std::vector<NodeStatus>& nodes) {
  std::string missing;
  for (const NodeStatus& node : nodes) {
    if (!node.status) missing += (missing.empty() ? "" : "\n") + node.name + ": " + node.status.error().message;
  }
  return missing.empty() ? Result<void>() : Error{missing};
}

// Prints what each has answered.
Result<void> post_to_all(const Arguments& arguments, const Fleet& fleet, const std::string& path,
                         const json& body) {
  std::string failed;
  auto answers = json::array();
  for (const NodeAnswer& node : post_to(fleet.nodes, fleet.access, path, body)) {
    if (!node.answer) {
      failed += (failed.empty() ? "" : "\n") + node.name + ": " + node.answer.error().message;
    } else if (arguments.json) {
      answers.push_back({{"node", node.name}, {"answer", *node.answer}});
    } else {
      print(node.name + ": " + *node.answer + "\n");
    }
  }
  if (arguments.json) print(json_text(answers, -1));
  if (!failed.empty()) return Error{failed};
  return {};
}

// Tells a node that has `known` what it lacks of `newest`, in pieces that it takes.
Result<void> tell_lights(const FleetNode& node, const AdminAccess& access, const json& known, const json& newest) {
  const json& has = list(known, "lights");
  json piece = json::array();
  const auto send = [&]() -> Result<void> {
    if (piece.empty()) return {};
    const auto answer = post_to({node}, access, "/lights", {{"lights", std::exchange(piece, json::array())}});
    return answer.front().answer ? Result<void>() : Error{node.name + ": " + answer.front().answer.error().message};
  };
  for (const json& light : list(newest, "lights")) {
    if (std::ranges::find(has, light) != has.end()) continue;
    if (piece.dump().size() + light.dump().size() > kPieceBytes) {
      if (auto sent = send(); !sent) return sent;
    }
    piece.push_back(light);
  }
  return send();
}

}  // namespace

Result<void> show_fleet(Arguments& arguments) {
  const auto fleet = fleet_of(arguments);
  if (!fleet) return fleet.error();
  const auto statuses = status_of(fleet->nodes, fleet->access);
  print(arguments.json ? json_text(fleet_json(statuses), 2) : fleet_text(statuses));
  return all_answered(statuses);
}

Result<void> post_to_node(Arguments& arguments, const std::string& path) {
  const auto fleet = fleet_of(arguments);
  if (!fleet) return fleet.error();
  const auto node = node_named(fleet->nodes, arguments.node);
  if (!node) return wrong_usage(arguments, node.error());
  return post_to_all(arguments, {{*node}, fleet->access}, path, json::object());
}

// All nodes get one time, by which the newest change is told from others (share_lights).
Result<void> change_light_of_fleet(Arguments& arguments, const std::string& path) {
  const auto fleet = fleet_of(arguments);
  if (!fleet) return fleet.error();
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  json change = arguments.light_change;
  change["at_ms"] = std::chrono::duration_cast<std::chrono::milliseconds>(now).count();
  return post_to_all(arguments, *fleet, path, change);
}

Result<void> share_lights(Arguments& arguments) {
  const auto fleet = fleet_of(arguments);
  if (!fleet) return fleet.error();
  const auto known = lights_of(fleet->nodes, fleet->access);
  std::vector<json> tables;
  std::vector<FleetNode> there;
  for (size_t i = 0; i < known.size(); ++i) {
    if (!known[i].status) continue;
    tables.push_back(*known[i].status);
    there.push_back(fleet->nodes[i]);
  }
  const auto answered = all_answered(known);
  const std::filesystem::path file = arguments.lights_file;
  if (file.empty()) {
    const json newest = newest_lights(tables);
    print(arguments.json ? json_text(newest, 2) : lights_text(newest));
    for (size_t i = 0; i < there.size(); ++i) {
      if (auto told = tell_lights(there[i], fleet->access, tables[i], newest); !told) return told;
    }
    return answered;
  }
  if (!answered) std::fprintf(stderr, "gnomonctl: %s\n", answered.error().message.c_str());
  if (std::filesystem::exists(file)) {
    const json own = json::parse(read_file(file), nullptr, false);
    if (!own.is_object()) return Error{file.string() + ": it is not what changed lights are kept in"};
    tables.push_back(own);
  }
  return write_file(file, newest_lights(tables).dump(1) + "\n", kLightsMode);
}

std::string lights_text(const json& lights) {
  Table table({"SCENE", ">LIGHT", "CHANGE"});
  for (const json& light : list(lights, "lights")) {
    const std::string change = light.value("change", json::object()).dump(-1, ' ', true);
    table.add({text(light, "scene"), whole(light, "light"), change == "{}" ? "as in its file" : change});
  }
  return table.text();
}

}  // namespace gnomon::ctl
