// A configuration file of which a program changes some keys and leaves the others. Its comments are lost.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/result.h"

namespace YAML {
class Node;
}

namespace gnomon::daemon {

// A key is dotted, as in "server.listen". Belongs to one thread.
class EditedConfig {
 public:
  // Error: it is not YAML, or no map. Empty text has no keys.
  static Result<EditedConfig> read(const std::string& text);
  ~EditedConfig();
  EditedConfig(EditedConfig&&) noexcept;
  EditedConfig& operator=(EditedConfig&&) noexcept;

  bool has(const std::string& key) const;
  std::string text(const std::string& key) const;  // of a scalar; empty if there is none
  // The items of a list, or of each what stands in `member`; empty if there is no such list.
  std::vector<std::string> texts(const std::string& key, const std::string& member = {}) const;

  // `value` is YAML. An item of a list that has a `name` keeps the keys of the item that had it before and are not in
  // `value`. Precondition: `value` and what it comes below are YAML of that kind.
  void set(const std::string& key, const std::string& value);

  std::string written() const;

 private:
  explicit EditedConfig(const YAML::Node& root);
  std::unique_ptr<YAML::Node> root_;  // a map
};

}  // namespace gnomon::daemon
