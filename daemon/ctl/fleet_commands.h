// What gnomonctl does with --fleet, for all nodes or one. Where some do not answer, the others are shown or told, and the
// error names those.
#pragma once

#include "daemon/ctl/arguments.h"

namespace gnomon::ctl {

Result<void> show_fleet(Arguments& arguments);
// Of the node that --node names.
Result<void> post_to_node(Arguments& arguments, const std::string& path);
// On all nodes, whether they have the scene or may get it later.
Result<void> change_light_of_fleet(Arguments& arguments, const std::string& path);
// Shows what is changed of the lights. Tells all nodes what others know, or writes it to --file, in which a node that is
// about to start finds it; that some do not answer is then no error.
Result<void> share_lights(Arguments& arguments);

// Of /lights, for people.
std::string lights_text(const nlohmann::json& lights);

}  // namespace gnomon::ctl
