// Eight clients of two tenants through gnomon-load: all are served, rightly, and the daemon's metrics agree.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/system/e2e/daemon.h"

namespace gnomon::tests {
namespace {

class Load : public testing::Test {
 protected:
  nlohmann::json run_load(std::vector<std::string> more, int expected_status = 0) {
    const auto file = folder_.path() / "load.json";
    std::vector<std::string> arguments{"--server",    daemon_.server(), "--pin",  daemon_.pin(), "--scene",
                                       "living_room", "--size",         "160x90", "--json",      file.string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const auto [status, output] = run("gnomon-load", arguments);
    EXPECT_EQ(status, expected_status) << output;
    EXPECT_NE(output.find("total, 8 clients"), std::string::npos) << output;
    const auto report = nlohmann::json::parse(read_file(file), nullptr, false);
    EXPECT_EQ(report.value("suite", ""), "load");
    return report.value("rows", nlohmann::json::array());
  }

  static uint64_t sum(const nlohmann::json& rows, const std::string& scope, const std::string& tenant,
                      const std::string& key) {
    uint64_t total = 0;
    for (const auto& row : rows) {
      if (row["scope"] == scope && (tenant.empty() || row["tenant"] == tenant)) total += row[key].get<uint64_t>();
    }
    return total;
  }

  TemporaryFolder folder_;
  Daemon daemon_;
};

TEST_F(Load, EveryClientIsServedAndCountersAgree) {
  const auto rows = run_load({"--seconds", "8", "--rate", "0", "--tenant", "studio::4", "--tenant", "arcade::4"});
  ASSERT_EQ(rows.size(), 8u + 2u + 1u);
  for (const auto& row : rows) {
    EXPECT_GT(row["frames"].get<uint64_t>(), 0u) << row;
    EXPECT_EQ(row["invalid_slices"].get<uint64_t>(), 0u) << row;
    EXPECT_FALSE(row.contains("error")) << row;
  }
  for (const std::string tenant : {"studio", "arcade"}) {
    const uint64_t complete = sum(rows, "client", tenant, "frames");
    EXPECT_EQ(complete, sum(rows, "tenant", tenant, "frames"));
    const uint64_t came = complete + sum(rows, "client", tenant, "incomplete_frames");
    // Sent are those that came, those whose every slice was lost, and those under way when the clients left.
    const uint64_t asked = sum(rows, "client", tenant, "cameras");
    const double sent = daemon_.metric("gnomon_visibility_buffers_total", {"tenant=\"" + tenant + "\""});
    EXPECT_GE(sent, static_cast<double>(came));
    EXPECT_LE(sent, static_cast<double>(asked));
    EXPECT_LE(asked - came, 4u) << "one camera of each client may be unanswered at the end";
    const double bits = daemon_.metric("gnomon_visibility_values_total", {"tenant=\"" + tenant + "\""});
    EXPECT_EQ(bits, sent * 160 * 90 * 3);
  }
  EXPECT_TRUE(eventually([&] { return daemon_.sessions() == 0; })) << "clients said Bye";
}

TEST_F(Load, ARateBeyondWhatTheServerCanDoIsSaid) {
  constexpr int kUnanswered = 3;
  const auto rows =
      run_load({"--seconds", "4", "--rate", "200", "--tenant", "studio::1", "--tenant", "arcade::7"}, kUnanswered);
  const auto& total = rows.back();
  EXPECT_EQ(total["invalid_slices"].get<uint64_t>(), 0u);
  EXPECT_GT(total["cameras"].get<uint64_t>(), total["frames"].get<uint64_t>()) << "the newest camera wins";
  EXPECT_GT(sum(rows, "client", "studio", "frames"), 0u) << "one client is not drowned by seven";
  EXPECT_GT(daemon_.metric("gnomon_frames_coalesced_total"), 0);
}

}  // namespace
}  // namespace gnomon::tests
