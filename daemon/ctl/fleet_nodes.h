// What gnomonctl asks and tells the nodes of a fleet, all of them or one.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "daemon/ctl/admin_client.h"

namespace gnomon::ctl {

struct FleetNode {
  std::string name;
  std::string address;  // of its admin server, as AdminAccess has it
};

// Whether `text` names nodes itself, and not the file that does.
bool nodes_are_named(const std::string& text);

// Of `text`, "NAME=ADDRESS" with a comma between two nodes, or a file with a line "NAME ADDRESS" for each; there, what
// follows a # is a comment. Error: the line or the word that is none.
Result<std::vector<FleetNode>> fleet_nodes(const std::string& text);

// That of the nodes which has the name. Error: the names that there are.
Result<FleetNode> node_named(const std::vector<FleetNode>& nodes, const std::string& name);

struct NodeStatus {
  std::string name;
  Result<nlohmann::json> status;  // /status of the node, or why it did not answer
};

struct NodeAnswer {
  std::string name;
  Result<std::string> answer;
};

// The three ask all nodes at once and block until the last has answered or its time is over. `access`: with which token, and
// whom to trust; its address is not looked at.
std::vector<NodeStatus> status_of(const std::vector<FleetNode>& nodes, const AdminAccess& access);
// As status_of(), what operators have changed of the lights (/lights).
std::vector<NodeStatus> lights_of(const std::vector<FleetNode>& nodes, const AdminAccess& access);
std::vector<NodeAnswer> post_to(const std::vector<FleetNode>& nodes, const AdminAccess& access,
                                const std::string& path, const nlohmann::json& body);

// Of every light the newest change in any of `tables`, each as /lights has it.
nlohmann::json newest_lights(const std::vector<nlohmann::json>& tables);

// For people, and for programs: an array with the node's name, and its status or an `error`.
std::string fleet_text(const std::vector<NodeStatus>& fleet);
nlohmann::json fleet_json(const std::vector<NodeStatus>& fleet);

}  // namespace gnomon::ctl
