// The schema of the configuration: every key, where it goes and what is allowed.
#pragma once

#include "daemon/config/config.h"
#include "daemon/config/yaml_schema.h"

namespace gnomon::daemon {

const schema::Keys<Config>& config_keys();

}  // namespace gnomon::daemon
