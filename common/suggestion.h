// What somebody may have meant who wrote a name that there is not.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace gnomon {

// The name that is nearest to `written`, if it is near enough for a slip: few characters inserted, deleted or changed.
std::optional<std::string> suggestion(const std::string& written, const std::vector<std::string>& known);

}  // namespace gnomon
