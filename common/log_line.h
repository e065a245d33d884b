// A line as the log has it, for those who write it elsewhere. Apart from log.h, which nearly every source includes.
#pragma once

#include <string>

#include "common/log.h"

namespace gnomon::log {

// With its end: {"time":"...","level":"info","event":"...", ...}
std::string json_line(std::string_view event, Fields fields);

}  // namespace gnomon::log
