#include "client/cli/report.h"

#include <unistd.h>

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

}  // namespace

Result<void> write_report(const std::filesystem::path& file, const Report& report) {
  const nlohmann::ordered_json whole = {{"suite", report.suite},   {"host", host_name()}, {"device", report.device},
                                        {"driver", report.driver}, {"date", utc_date()},  {"rows", report.rows}};
  std::ofstream out(file);
  out << whole.dump(2) << '\n';
  if (!out.flush()) return Error{"cannot write " + file.string()};
  return {};
}

}  // namespace gnomon::client
