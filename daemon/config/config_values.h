// What a configuration says, key by key as text, so that a reload can tell what it changed.
#pragma once

#include <map>
#include <string>

namespace YAML {
class Node;
}

namespace gnomon::daemon {

// By dotted key; items of a list by their `name`, else by their place: "tenants.studio.weight" -> "3". Keys that are not
// set, and have their default, are absent.
using ConfigValues = std::map<std::string, std::string>;

// Adds what `node` says over what was said before; a list replaces the whole list.
void add_values(ConfigValues& values, const YAML::Node& node, const std::string& path = {});

// "tenants.studio.weight: 1 -> 3, server.max_sessions: (default) -> 100"; empty if there is no difference. Of
// tokens' hashes it says only how many came and went.
std::string changes_between(const ConfigValues& before, const ConfigValues& after);

}  // namespace gnomon::daemon
