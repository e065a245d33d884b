// The report of a suite, as a table for people and as JSON for scripts:
//   {"suite", "host", "device", "driver", "date", "rows": [...]}
// Every row is flat: names of what was run, and figures with the unit in the key.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/result.h"

namespace gnomon::bench {

struct Report {
  std::string suite;
  std::string device;  // empty if no device was used
  std::string driver;
  std::vector<nlohmann::ordered_json> rows;
};

// Columns are the rows' keys in the order of their first appearance.
void print_table(const Report& report);

Result<void> write_json(const Report& report, const std::filesystem::path& file);

// Progress, to standard error.
void say(const std::string& line);

double median(std::vector<double> values);

}  // namespace gnomon::bench
