// The scene has the requested size, and the suite writes its rows and its plot.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "scenes/world_mesh.h"
#include "tests/bench/growth_plot.h"
#include "tests/bench/growth_scene.h"
#include "tests/system/e2e/process.h"

namespace gnomon::bench {
namespace {

TEST(GrowthScene, HasWhatWasAskedFor) {
  const uint64_t vessel = growth_scene(0, 1)->meshes[1].primitives[0].triangles.size();
  for (const uint64_t asked : {5'000u, 10'000u, 77'777u, 300'000u}) {
    const auto scene = growth_scene(asked, 7);
    EXPECT_LE(scene->triangle_count, asked);
    EXPECT_GT(scene->triangle_count + vessel, asked);
    EXPECT_EQ(scene->lights.size(), 7u);
    const scenes::WorldMesh mesh = scenes::build_world_mesh(*scene);
    EXPECT_EQ(mesh.triangles.size(), scene->triangle_count) << "some have no area";
    for (const glm::vec3& p : mesh.positions)
      ASSERT_TRUE(glm::all(glm::lessThanEqual(scene->bounds.min - 1e-4f, p)) &&
                  glm::all(glm::lessThanEqual(p, scene->bounds.max + 1e-4f)));
  }
}

TEST(GrowthScene, LampsHangApartAndWithin) {
  const auto scene = growth_scene(5'000, 64);
  for (size_t i = 0; i < scene->lights.size(); ++i) {
    const glm::vec3 p = scene->lights[i].position;
    EXPECT_TRUE(glm::all(glm::lessThan(scene->bounds.min, p)) && glm::all(glm::lessThan(p, scene->bounds.max)));
    for (size_t j = 0; j < i; ++j) EXPECT_GT(glm::distance(p, scene->lights[j].position), 0.2f);
  }
}

TEST(GrowthPlot, RefusesOtherEndings) {
  const auto refused = plot_growth({}, "growth.txt");
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find(".svg"), std::string::npos);
}

TEST(GrowthSuite, LeavesRowsAndAPlot) {
  const tests::TemporaryFolder folder;
  const auto json = folder.path() / "growth.json", plot = folder.path() / "growth.svg";
  const auto [status, output] = tests::run("gnomon-bench", {"growth", "--quick", "--size", "160x90", "--frames",
                                                            "1", "--json", json.string(), "--plot", plot.string()});
  ASSERT_EQ(status, 0) << output;
  const auto report = nlohmann::json::parse(tests::read_file(json));
  EXPECT_EQ(report["suite"], "growth");
  ASSERT_EQ(report["rows"].size(), 4u);
  for (const auto& row : report["rows"]) {
    EXPECT_GT(row["ms"].get<double>(), 0);
    EXPECT_GT(row["readback_bytes"].get<double>(), 0);
    EXPECT_GE(row["ms"].get<double>(), row["raster_ms"].get<double>() + row["trace_ms"].get<double>());
  }
  EXPECT_GT(report["rows"][1]["triangles"], report["rows"][0]["triangles"]);
  EXPECT_GT(report["rows"][3]["lights"], report["rows"][2]["lights"]);
  const std::string picture = tests::read_file(plot);
  EXPECT_NE(picture.find("<svg"), std::string::npos);
  EXPECT_NE(picture.find("triangles"), std::string::npos);
}

}  // namespace
}  // namespace gnomon::bench
