#include "daemon/config/edited_config.h"

#include <yaml-cpp/yaml.h>

#include <sstream>

namespace gnomon::daemon {
namespace {

// yaml-cpp's nodes are references: `=` on one would change what it stands for.
YAML::Node found(const YAML::Node& root, const std::string& key) {
  YAML::Node at;
  at.reset(root);
  std::istringstream steps(key);
  for (std::string step; std::getline(steps, step, '.');) {
    if (!at.IsMap()) return YAML::Node(YAML::NodeType::Undefined);
    const YAML::Node& below = at;
    YAML::Node next = below[step];
    if (!next.IsDefined()) return YAML::Node(YAML::NodeType::Undefined);
    at.reset(next);
  }
  return at;
}

std::string member_of(const YAML::Node& item, const std::string& member) {
  const YAML::Node value = item.IsMap() ? item[member] : YAML::Node(YAML::NodeType::Undefined);
  return value.IsDefined() && value.IsScalar() ? value.Scalar() : "";
}

// Adds to each item with a name what the item of that name in `before` has besides.
void keep_members(YAML::Node list, const YAML::Node& before) {
  if (!list.IsSequence() || !before.IsDefined() || !before.IsSequence()) return;
  for (YAML::Node item : list) {
    const std::string name = member_of(item, "name");
    if (name.empty()) continue;
    for (const YAML::Node& old : before) {
      if (member_of(old, "name") != name) continue;
      for (const auto& entry : old) {
        if (!item[entry.first.Scalar()].IsDefined()) item[entry.first.Scalar()] = YAML::Clone(entry.second);
      }
    }
  }
}

// A line for each key of each item, as people write it.
void write_by_lines(YAML::Node list) {
  if (!list.IsSequence() || list.size() == 0 || !list[0].IsMap()) return;
  list.SetStyle(YAML::EmitterStyle::Block);
  for (YAML::Node item : list) item.SetStyle(YAML::EmitterStyle::Block);
}

}  // namespace

EditedConfig::EditedConfig(const YAML::Node& root) : root_(std::make_unique<YAML::Node>(root)) {}
EditedConfig::~EditedConfig() = default;
EditedConfig::EditedConfig(EditedConfig&&) noexcept = default;
EditedConfig& EditedConfig::operator=(EditedConfig&&) noexcept = default;

Result<EditedConfig> EditedConfig::read(const std::string& text) {
  try {
    const std::vector<YAML::Node> documents = YAML::LoadAll(text);
    if (documents.size() > 1) return Error{"more than one YAML document"};
    const YAML::Node root = documents.empty() ? YAML::Node() : documents.front();
    if (root.IsNull()) return EditedConfig(YAML::Node(YAML::NodeType::Map));
    if (!root.IsMap()) return Error{"no map of sections"};
    return EditedConfig(root);
  } catch (const YAML::Exception& e) {
    return Error{std::string("not YAML: ") + e.what()};
  }
}

bool EditedConfig::has(const std::string& key) const { return found(*root_, key).IsDefined(); }

std::string EditedConfig::text(const std::string& key) const {
  const YAML::Node value = found(*root_, key);
  return value.IsDefined() && value.IsScalar() ? value.Scalar() : "";
}

std::vector<std::string> EditedConfig::texts(const std::string& key, const std::string& member) const {
  const YAML::Node list = found(*root_, key);
  std::vector<std::string> all;
  if (!list.IsDefined() || !list.IsSequence()) return all;
  for (const YAML::Node& item : list)
    all.push_back(member.empty() && item.IsScalar() ? item.Scalar() : member_of(item, member));
  return all;
}

void EditedConfig::set(const std::string& key, const std::string& value) {
  YAML::Node at;
  at.reset(*root_);
  size_t begin = 0;
  for (size_t dot = key.find('.'); dot != std::string::npos; begin = dot + 1, dot = key.find('.', begin)) {
    const std::string step = key.substr(begin, dot - begin);
    if (!at[step].IsDefined() || !at[step].IsMap()) at[step] = YAML::Node(YAML::NodeType::Map);
    YAML::Node below = at[step];
    at.reset(below);
  }
  YAML::Node set = YAML::Load(value);
  keep_members(set, found(*root_, key));
  write_by_lines(set);
  at[key.substr(begin)] = set;
}

std::string EditedConfig::written() const {
  YAML::Emitter out;
  out << *root_;
  return std::string(out.c_str()) + "\n";
}

}  // namespace gnomon::daemon
