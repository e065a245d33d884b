// The contents of --json FILE: {"suite", "host", "device", "driver", "date", "rows": [flat objects]}.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "common/result.h"

namespace gnomon::client {

struct Report {
  std::string suite;
  std::string device;  // as far as a client knows it: the server's address
  std::string driver;  // the tracer that the server named
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
};

// The rows alone, as CSV: a line of the keys of all, then a line for each.
Result<void> write_csv(const std::filesystem::path& file, const Report& report);

Result<void> write_report(const std::filesystem::path& file, const Report& report);

}  // namespace gnomon::client
