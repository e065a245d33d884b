#include "daemon/config/yaml_schema.h"

#include <algorithm>
#include <numeric>

namespace gnomon::daemon::schema {
namespace {

// The Levenshtein distance: how many characters to insert, delete or change.
size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), size_t{0});
  for (size_t i = 1; i <= a.size(); ++i) {
    size_t diagonal = std::exchange(row[0], i);
    for (size_t j = 1; j <= b.size(); ++j) {
      const size_t change = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, change});
    }
  }
  return row.back();
}

std::string suggestion(const std::string& name, const std::vector<std::string>& known) {
  if (known.empty() || name.size() > 64) return "";
  const auto nearest = std::min_element(known.begin(), known.end(), [&](const auto& a, const auto& b) {
    return edit_distance(name, a) < edit_distance(name, b);
  });
  const bool near = edit_distance(name, *nearest) <= std::max<size_t>(2, nearest->size() / 3);
  return near ? "; did you mean " + *nearest + "?" : ";";
}

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

}  // namespace

std::string Source::at(const YAML::Mark& mark) const {
  return has_lines && !mark.is_null() ? name + ":" + std::to_string(mark.line + 1) : name;
}

Error Value::refuse(const std::string& why) const {
  return {place() + ": " + (path.empty() ? "" : path + ": ") + why};
}

Error Value::not_allowed(const std::string& allowed) const {
  return refuse(shown(node) + " is not allowed; allowed: " + allowed);
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

Result<std::vector<std::pair<std::string, Value>>> entries_of(const Value& value,
                                                              const std::vector<std::string>& known) {
  std::vector<std::pair<std::string, Value>> entries;
  if (value.node.IsNull()) return entries;  // a section whose keys are all commented out
  if (!value.node.IsMap()) return value.not_allowed("a map with the keys " + join(known));
  for (const auto& pair : value.node) {
    const std::string name = any_scalar(pair.first).value_or("");
    const std::string path = value.path.empty() ? name : value.path + "." + name;
    const Value entry{value.source, path, pair.second, pair.first.Mark()};
    if (std::find(known.begin(), known.end(), name) == known.end()) {
      return entry.refuse("unknown key" + suggestion(name, known) + " allowed here: " + join(known));
    }
    const bool repeated =
        std::any_of(entries.begin(), entries.end(), [&](const auto& seen) { return seen.first == name; });
    if (repeated) return entry.refuse("given twice; allowed: once");
    entries.emplace_back(name, entry);
  }
  return entries;
}

}  // namespace gnomon::daemon::schema
