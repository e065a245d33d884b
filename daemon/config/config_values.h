// What a configuration says, key by key as text, so that a reload can tell what it changed.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

namespace YAML {
class Node;
}

namespace gnomon::daemon {

// By dotted key; items of a list by their `name`, else by their place: "tenants.studio.weight" -> "3". Keys that are not
// set, and have their default, are absent.
using ConfigValues = std::map<std::string, std::string>;

// Adds what `node` says over what was said before; a list replaces the whole list.
void add_values(ConfigValues& values, const YAML::Node& node, const std::string& path = {});

// Puts what `before` says of the key, and of those below it, in the place of what `values` says.
void keep_values(ConfigValues& values, const ConfigValues& before, const std::string& key);

// Where a configuration says what: "gnomond.yaml:12:3", by the same keys, and by those of sections and items.
using ConfigPlaces = std::map<std::string, std::string>;

// As add_values(). `place_of` gives the place of a node, or "" for one that has none of its own.
void add_places(ConfigPlaces& places, const YAML::Node& node,
                const std::function<std::string(const YAML::Node&)>& place_of, const std::string& path = {});

// "tenants.studio.weight: 1 -> 3", "server.max_sessions: (default) -> 100": one for each key that differs. Of an item that
// came or went it says so, "tenants.museum: added", of one that went nothing else, and of tokens' hashes only how many
// came and went.
std::vector<std::string> changes_between(const ConfigValues& before, const ConfigValues& after);

}  // namespace gnomon::daemon
