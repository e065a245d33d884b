#include "daemon/config/yaml_schema.h"

#include <algorithm>

#include "common/suggestion.h"

namespace gnomon::daemon::schema {
namespace {

std::string shown(const YAML::Node& node) {
  switch (node.Type()) {
    case YAML::NodeType::Undefined:
    case YAML::NodeType::Null: return "nothing";
    case YAML::NodeType::Sequence: return "a list like this";
    case YAML::NodeType::Map: return "a map";
    case YAML::NodeType::Scalar: break;
  }
  const std::string& text = node.Scalar();
  return "\"" + (text.size() > 60 ? text.substr(0, 60) + "..." : text) + "\"";
}

std::string unknown_key(const std::string& name, const std::vector<std::string>& known) {
  const auto meant = suggestion(name, known);
  return "unknown key;" + (meant ? " did you mean " + *meant + "?" : "") + " allowed here: " + join(known);
}

}  // namespace

std::string Source::at(const YAML::Mark& mark) const {
  if (!has_lines || mark.is_null()) return name;
  return name + ":" + std::to_string(mark.line + 1) + ":" + std::to_string(mark.column + 1);
}

void Value::refuse(const std::string& why) const {
  source.mistakes.errors.push_back({place() + ": " + (path.empty() ? "" : path + ": ") + why});
  source.mistakes.keys.insert(path);
}

void Value::not_allowed(const std::string& allowed) const {
  refuse(shown(node) + " is not allowed; allowed: " + allowed);
}

std::optional<std::string> plain_scalar(const YAML::Node& node) {
  if (!node.IsScalar() || node.Tag() == "!") return std::nullopt;  // "!": quoted
  return node.Scalar();
}

std::optional<std::string> any_scalar(const YAML::Node& node) {
  if (!node.IsScalar()) return std::nullopt;
  return node.Scalar();
}

std::string join(const std::vector<std::string>& words) {
  std::string joined;
  for (const std::string& word : words) joined += (joined.empty() ? "" : ", ") + word;
  return joined;
}

std::vector<std::pair<std::string, Value>> entries_of(const Value& value, const std::vector<std::string>& known) {
  std::vector<std::pair<std::string, Value>> entries;
  if (value.node.IsNull()) return entries;  // a section whose keys are all commented out
  if (!value.node.IsMap()) {
    value.not_allowed("a map with the keys " + join(known));
    return entries;
  }
  const std::string above = value.path.empty() ? "" : value.path + ".";
  for (const auto& pair : value.node) {
    const std::string name = any_scalar(pair.first).value_or("");
    const Value entry{value.source, above + name, pair.second, pair.first.Mark()};
    const bool repeated =
        std::any_of(entries.begin(), entries.end(), [&](const auto& seen) { return seen.first == name; });
    if (std::find(known.begin(), known.end(), name) == known.end()) {
      entry.refuse(unknown_key(name, known));
      if (const auto meant = suggestion(name, known)) value.source.mistakes.keys.insert(above + *meant);
    } else if (repeated) {
      entry.refuse("given twice; allowed: once");
    } else {
      entries.emplace_back(name, entry);
    }
  }
  return entries;
}

}  // namespace gnomon::daemon::schema
