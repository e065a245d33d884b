// The schema of the configuration: every key, where it goes and what is allowed.
#pragma once

#include "daemon/config.h"
#include "daemon/yaml_schema.h"

namespace gnomon::daemon {

const schema::Keys<Config>& config_keys();

}  // namespace gnomon::daemon
