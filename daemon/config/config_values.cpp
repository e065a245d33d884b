#include "daemon/config/config_values.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <set>
#include <sstream>

namespace gnomon::daemon {
namespace {

constexpr const char* kTokenHashes = "token_sha256";
constexpr const char* kDefault = "(default)";

std::string below(const std::string& path, const std::string& name) {
  return path.empty() ? name : path + "." + name;
}

void forget_below(ConfigValues& values, const std::string& path) {
  std::erase_if(values,
                [&](const auto& entry) { return entry.first == path || entry.first.starts_with(path + "."); });
}

std::string name_of(const YAML::Node& item, size_t place) {
  const YAML::Node name = item.IsMap() ? item["name"] : YAML::Node(YAML::NodeType::Undefined);
  return name.IsDefined() && name.IsScalar() ? name.Scalar() : std::to_string(place);
}

void add_list(ConfigValues& values, const YAML::Node& list, const std::string& path) {
  forget_below(values, path);
  if (path.ends_with(kTokenHashes)) {
    for (const YAML::Node& hash : list) values[path] += hash.Scalar() + "\n";
    return;
  }
  if (list.size() == 0) values[path] = "[]";
  for (size_t i = 0; i < list.size(); ++i) add_values(values, list[i], below(path, name_of(list[i], i)));
}

std::set<std::string> lines_of(const std::string& text) {
  std::istringstream stream(text);
  std::set<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.insert(line);
  return lines;
}

// Hashes are not shown, as a token that is easy to guess could be found from its own.
std::string change_of_tokens(const std::string& before, const std::string& after) {
  const auto old = lines_of(before), now = lines_of(after);
  const auto added = std::count_if(now.begin(), now.end(), [&](const auto& hash) { return !old.contains(hash); });
  const auto removed = std::count_if(old.begin(), old.end(), [&](const auto& hash) { return !now.contains(hash); });
  return std::to_string(added) + " added, " + std::to_string(removed) + " removed";
}

// The items of lists that have a name in `values` and are not in `others`: "tenants.museum".
std::vector<std::string> items_missing(const ConfigValues& others, const ConfigValues& values) {
  std::vector<std::string> items;
  for (const auto& [key, name] : values) {
    const std::string ending = "." + name + ".name";
    if (key.ends_with(ending) && !others.contains(key)) items.push_back(key.substr(0, key.size() - 5));
  }
  return items;
}

std::string value_in(const ConfigValues& values, const std::string& key, bool list) {
  const auto found = values.find(key);
  return found != values.end() ? found->second : list ? "" : kDefault;
}

}  // namespace

void add_values(ConfigValues& values, const YAML::Node& node, const std::string& path) {
  if (node.IsScalar()) {
    values[path] = node.Scalar().empty() ? "''" : node.Scalar();
  } else if (node.IsSequence()) {
    add_list(values, node, path);
  } else if (node.IsMap()) {
    for (const auto& entry : node) add_values(values, entry.second, below(path, entry.first.Scalar()));
  }
}

void keep_values(ConfigValues& values, const ConfigValues& before, const std::string& key) {
  forget_below(values, key);
  for (const auto& entry : before) {
    if (entry.first == key || entry.first.starts_with(key + ".")) values.insert(entry);
  }
}

void add_places(ConfigPlaces& places, const YAML::Node& node,
                const std::function<std::string(const YAML::Node&)>& place_of, const std::string& path) {
  if (node.IsSequence()) {
    for (size_t i = 0; i < node.size(); ++i) {
      const std::string item = below(path, name_of(node[i], i));
      places[item] = place_of(node[i]);
      add_places(places, node[i], place_of, item);
    }
  } else if (node.IsMap()) {
    for (const auto& entry : node) {
      const std::string key = below(path, entry.first.Scalar());
      places[key] = place_of(entry.first);
      add_places(places, entry.second, place_of, key);
    }
  }
}

std::vector<std::string> changes_between(const ConfigValues& before, const ConfigValues& after) {
  std::map<std::string, std::string> changes;  // by key, for their order
  ConfigValues old_values = before;
  for (const std::string& item : items_missing(after, before)) {
    forget_below(old_values, item);
    changes[item] = "removed";
  }
  std::set<std::string> keys;
  for (const auto& [key, value] : old_values) keys.insert(key);
  for (const auto& [key, value] : after) keys.insert(key);
  for (const std::string& key : keys) {
    const bool tokens = key.ends_with(kTokenHashes);
    const std::string old = value_in(old_values, key, tokens), now = value_in(after, key, tokens);
    if (old != now) changes[key] = tokens ? change_of_tokens(old, now) : old + " -> " + now;
  }
  for (const std::string& item : items_missing(before, after)) {
    changes.erase(item + ".name");
    changes[item] = "added";
  }
  std::vector<std::string> lines;
  for (const auto& [key, change] : changes) lines.push_back(key + ": " + change);
  return lines;
}

}  // namespace gnomon::daemon
