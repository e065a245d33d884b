#include "tests/bench/report.h"

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <thread>

namespace gnomon::bench {
namespace {

std::string processor() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);)
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  return "unknown processor";
}

std::string now() {
  const std::time_t seconds = std::time(nullptr);
  char text[32];
  std::strftime(text, sizeof(text), "%Y-%m-%dT%H:%M:%SZ", std::gmtime(&seconds));
  return text;
}

std::string cell(const nlohmann::ordered_json& row, const std::string& key) {
  if (!row.contains(key) || row[key].is_null()) return "-";
  if (row[key].is_string()) return row[key].get<std::string>();
  if (!row[key].is_number_float()) return row[key].dump();
  char text[32];
  const double value = row[key].get<double>();
  std::snprintf(text, sizeof(text), value >= 100 ? "%.0f" : value >= 1 ? "%.2f" : "%.3f", value);
  return text;
}

std::vector<std::string> columns(const Report& report) {
  std::vector<std::string> keys;
  for (const auto& row : report.rows)
    for (const auto& [key, value] : row.items())
      if (std::find(keys.begin(), keys.end(), key) == keys.end()) keys.push_back(key);
  return keys;
}

}  // namespace

void print_table(const Report& report) {
  if (!report.device.empty()) std::printf("%s, %s\n", report.device.c_str(), report.driver.c_str());
  const std::vector<std::string> keys = columns(report);
  std::vector<size_t> widths;
  for (const std::string& key : keys) {
    size_t width = key.size();
    for (const auto& row : report.rows) width = std::max(width, cell(row, key).size());
    widths.push_back(width);
  }
  const auto print_row = [&](auto text_of) {
    for (size_t i = 0; i < keys.size(); ++i)
      std::printf("%s%-*s", i ? "  " : "", static_cast<int>(widths[i]), text_of(keys[i]).c_str());
    std::printf("\n");
  };
  print_row([](const std::string& key) { return key; });
  for (const auto& row : report.rows) print_row([&](const std::string& key) { return cell(row, key); });
}

Result<void> write_json(const Report& report, const std::filesystem::path& file) {
  const nlohmann::ordered_json json{
      {"suite", report.suite},
      {"host", processor() + ", " + std::to_string(std::thread::hardware_concurrency()) + " threads"},
      {"device", report.device},
      {"driver", report.driver},
      {"date", now()},
      {"rows", report.rows}};
  std::ofstream out(file);
  out << json.dump(2) << "\n";
  out.close();
  if (!out) return Error{"could not write " + file.string()};
  return {};
}

void say(const std::string& line) { std::fprintf(stderr, "%s\n", line.c_str()); }

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace gnomon::bench
