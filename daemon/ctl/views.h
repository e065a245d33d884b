// The contents of /status as text for people.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace gnomon::ctl {

std::string status_text(const nlohmann::json& status);
std::string sessions_text(const nlohmann::json& status);
std::string scenes_text(const nlohmann::json& status);

}  // namespace gnomon::ctl
