// The contents of --json FILE: {"suite", "host", "server", "device", "driver", "date", "rows": [flat objects]}, where
// "server" is of programs that asked one.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "common/result.h"

namespace gnomon::client {

struct Report {
  std::string suite;
  std::string device = {};  // that traced
  std::string driver = {};  // of a server: the tracer that it named
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  std::string server = {};  // its address
};

// The device in what a server tells of its tracer: "bvh on llvmpipe"; all of it where it names none.
std::string device_of(const std::string& tracer);

// The rows alone, as CSV: a line of the keys of all, then a line for each.
Result<void> write_csv(const std::filesystem::path& file, const Report& report);

Result<void> write_report(const std::filesystem::path& file, const Report& report);

}  // namespace gnomon::client
