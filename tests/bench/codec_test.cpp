// The suite writes its rows and its plot, here for small frames.
#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>

#include "tests/system/e2e/process.h"

namespace gnomon::bench {
namespace {

TEST(CodecSuite, LeavesRowsAndAPlot) {
  const tests::TemporaryFolder folder;
  const auto json = folder.path() / "codec.json", plot = folder.path() / "codec.svg";
  const auto [status, output] =
      tests::run("gnomon-bench", {"codec", "--scene", "living_room", "--size", "320x180", "--frames", "2", "--json",
                                  json.string(), "--plot", plot.string()});
  ASSERT_EQ(status, 0) << output;
  const auto report = nlohmann::json::parse(tests::read_file(json));
  EXPECT_EQ(report["suite"], "codec");
  ASSERT_GE(report["rows"].size(), 4u);
  std::map<std::string, double> bytes;
  for (const auto& row : report["rows"]) {
    EXPECT_EQ(row["scene"], "living_room");
    EXPECT_GT(row["encode_ms"].get<double>(), 0);
    EXPECT_GT(row["decode_ms"].get<double>(), 0);
    bytes[row["codec"]] = row["bytes_per_frame"];
  }
  EXPECT_LT(bytes.at("tiles_lz4"), 0.3 * bytes.at("raw32_lz4"));
  EXPECT_NE(tests::read_file(plot).find("tiles_lz4"), std::string::npos);
}

}  // namespace
}  // namespace gnomon::bench
