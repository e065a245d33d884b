#include "client/cli/report.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <ctime>
#include <fstream>

namespace gnomon::client {
namespace {

std::string host_name() {
  std::array<char, 256> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "unknown";
}

std::string utc_date() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  gmtime_r(&now, &parts);
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &parts);
  return text.data();
}

// A text in double quotes where it needs them (RFC 4180).
std::string csv_cell(const nlohmann::ordered_json& value) {
  if (!value.is_string()) return value.dump();
  const std::string text = value.get<std::string>();
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted(1, '"');
  for (const char c : text) quoted.append(c == '"' ? 2 : 1, c);
  return quoted.append(1, '"');
}

std::vector<std::string> keys_of(const nlohmann::ordered_json& rows) {
  std::vector<std::string> keys;
  for (const auto& row : rows) {
    for (const auto& [key, value] : row.items()) {
      if (std::find(keys.begin(), keys.end(), key) == keys.end()) keys.push_back(key);
    }
  }
  return keys;
}

}  // namespace

std::string device_of(const std::string& tracer) {
  constexpr std::string_view kOn = " on ";
  const size_t at = tracer.find(kOn);
  return at == std::string::npos ? tracer : tracer.substr(at + kOn.size());
}

Result<void> write_csv(const std::filesystem::path& file, const Report& report) {
  const std::vector<std::string> keys = keys_of(report.rows);
  std::ofstream out(file);
  for (size_t i = 0; i < keys.size(); ++i) out << (i == 0 ? "" : ",") << keys[i];
  out << '\n';
  for (const auto& row : report.rows) {
    for (size_t i = 0; i < keys.size(); ++i) {
      out << (i == 0 ? "" : ",") << (row.contains(keys[i]) ? csv_cell(row[keys[i]]) : "");
    }
    out << '\n';
  }
  if (!out.flush()) return Error{"cannot write " + file.string()};
  return {};
}

Result<void> write_report(const std::filesystem::path& file, const Report& report) {
  nlohmann::ordered_json whole = {{"suite", report.suite}, {"host", host_name()}};
  if (!report.server.empty()) whole["server"] = report.server;
  whole["device"] = report.device;
  whole["driver"] = report.driver;
  whole["date"] = utc_date();
  whole["rows"] = report.rows;
  std::ofstream out(file);
  out << whole.dump(2) << '\n';
  if (!out.flush()) return Error{"cannot write " + file.string()};
  return {};
}

}  // namespace gnomon::client
