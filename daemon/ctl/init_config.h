// The configuration that `gnomonctl init` writes. take_from_before() of init.h is here too.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/result.h"
#include "daemon/ctl/init.h"

namespace gnomon::ctl {

struct SceneEntry {
  std::string name;
  std::string file;
};

// The text of a configuration. Keys of the one before stay unless they are the request's; comments do not. Error: the one
// before cannot be read, or gnomond would not take what was asked for.
Result<std::string> config_text(const InitRequest& request, const std::vector<SceneEntry>& scenes,
                                const std::filesystem::path& cache_folder);

// The keys of the configuration `text` that a daemon which runs with the one before can take by a restart alone; nullopt
// if init has not written the one before.
std::optional<std::vector<std::string>> keys_for_restart(const std::filesystem::path& folder,
                                                         const std::string& text);

}  // namespace gnomon::ctl
