// Extents of lights (extras.gnomon.light), and the points that soft shadows are traced to.
#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <set>
#include <sstream>

#include "scenes/light_samples.h"
#include "scenes/motion.h"
#include "tests/unit/scenes/support/gltf_file.h"

namespace gnomon::scenes::testing {
namespace {

LightArea load_area(const json& said, const json& light = {{"type", "point"}}, json node = json::object()) {
  GltfFile file = triangle_file();
  node["extras"] = {{"gnomon", {{"light", said}}}};
  file.add_lamp(light, node);
  return file.load_or_fail()->lights.at(0).area;
}

TEST(LightArea, IsWhatTheNodesExtrasSay) {
  EXPECT_EQ(load_area({{"radius", 0.25}}), (LightArea{LightShape::sphere, {0.25f, 0, 0}, {0, 0.25f, 0}}));
  EXPECT_EQ(load_area({{"shape", "disc"}, {"radius", 2}}), (LightArea{LightShape::disc, {2, 0, 0}, {0, 2, 0}}));
  EXPECT_EQ(load_area({{"width", 3}, {"height", 1}}),
            (LightArea{LightShape::rectangle, {1.5f, 0, 0}, {0, 0.5f, 0}}));
}

TEST(LightArea, TurnsWithItsNodeAndIsNotScaled) {
  const double s = std::sqrt(0.5);  // a quarter turn about Z takes X to Y, and Y to -X
  const LightArea area = load_area({{"width", 3}, {"height", 1}}, {{"type", "point"}},
                                   {{"rotation", {0, 0, s, s}}, {"scale", {7, 7, 7}}});
  EXPECT_LT(glm::distance(area.u, glm::vec3(0, 1.5f, 0)), 1e-6f);
  EXPECT_LT(glm::distance(area.v, glm::vec3(-0.5f, 0, 0)), 1e-6f);
}

TEST(LightArea, WhatIsNoExtentIsLeftOut) {
  for (const json& odd : {json(1), json{{"radius", 0}}, json{{"radius", -1}}, json{{"radius", 1e9}},
                          json{{"radius", "1"}}, json{{"width", 1}}, json{{"shape", "tube"}, {"radius", 1}},
                          json{{"shape", "rectangle"}, {"radius", 1}}, json::array({1})}) {
    EXPECT_EQ(load_area(odd).shape, LightShape::point) << odd;
  }
  EXPECT_EQ(load_area({{"radius", 1}}, {{"type", "directional"}}).shape, LightShape::point);
}

// Of k points in two dimensions, each square of a grid of k has one.
TEST(LightSamples, EveryPixelsPointsAreStratified) {
  for (const uint32_t samples : {4u, 16u}) {
    const auto side = static_cast<uint32_t>(std::sqrt(samples));
    for (uint32_t pattern = 0; pattern < kSamplePatterns; ++pattern) {
      std::set<std::pair<int, int>> squares;
      for (uint32_t i = 0; i < samples; ++i) {
        const glm::dvec3 at = sample_fraction(pattern * samples + i, kSamplePatterns * samples);
        squares.insert({static_cast<int>(at.x * side), static_cast<int>(at.y * side)});
      }
      EXPECT_EQ(squares.size(), samples) << pattern;
    }
  }
}

TEST(LightSamples, AWindowOfFourByFourPixelsHasAllPatterns) {
  for (uint32_t x = 0; x < 5; ++x) {
    for (uint32_t y = 0; y < 5; ++y) {
      std::set<uint32_t> patterns;
      for (uint32_t i = 0; i < 16; ++i) patterns.insert(sample_pattern(x + i % 4, y + i / 4));
      EXPECT_EQ(patterns.size(), kSamplePatterns);
    }
  }
  std::set<uint32_t> of_quad;
  for (uint32_t i = 0; i < 4; ++i) of_quad.insert(sample_pattern(2 + i % 2, 2 + i / 2));
  EXPECT_LT(*of_quad.rbegin() - *of_quad.begin(), 4u);  // neighbouring runs, which are stratified together
}

// Seen along any axis, half of a sphere's points lie within the half of its disc's area, as an even disc's would.
TEST(LightSamples, ASphereLooksLikeAnEvenDiscFromEverySide) {
  const LightArea sphere{LightShape::sphere, {2, 0, 0}, {0, 2, 0}};
  const std::vector<glm::vec3> points = sample_offsets(sphere, 16);
  for (int axis = 0; axis < 3; ++axis) {
    int inside = 0;
    for (glm::vec3 p : points) {
      EXPECT_LE(glm::length(p), 2.0f);
      p[axis] = 0;
      inside += glm::dot(p, p) < 2.0f ? 1 : 0;
    }
    EXPECT_NEAR(inside, 128, 8) << axis;
  }
}

// The shares of a light of radius 1 that straight edges leave, as seen along Z: root mean square of what a pixel's own
// points say, and of what those of a 4x4 window say together.
struct ShareError {
  double of_pixel = 0, of_window = 0;
};

ShareError share_error(LightShape shape, uint32_t samples) {
  const std::vector<glm::vec3> points = sample_offsets({shape, {1, 0, 0}, {0, 1, 0}}, samples);
  ShareError sum;
  uint32_t edges = 0;
  for (uint32_t turn = 0; turn < 64; ++turn)
    for (int step = -19; step <= 19; ++step, ++edges) {
      const double angle = 6.283185307179586 * (turn + 0.5) / 64, far = step * 0.05;
      const double share = (std::acos(far) - far * std::sqrt(1 - far * far)) / 3.141592653589793;
      double seen_by_all = 0;
      for (uint32_t pattern = 0; pattern < kSamplePatterns; ++pattern) {
        double seen = 0;
        for (uint32_t i = 0; i < samples; ++i) {
          const glm::vec3& p = points[pattern * samples + i];
          seen += p.x * std::cos(angle) + p.y * std::sin(angle) > far;
        }
        seen_by_all += seen;
        sum.of_pixel += std::pow(seen / samples - share, 2) / kSamplePatterns;
      }
      sum.of_window += std::pow(seen_by_all / static_cast<double>(points.size()) - share, 2);
    }
  return {std::sqrt(sum.of_pixel / edges), std::sqrt(sum.of_window / edges)};
}

TEST(LightSamples, AWindowOfPixelsKnowsFarMoreThanOne) {
  for (const LightShape shape : {LightShape::disc, LightShape::sphere})
    for (const uint32_t samples : {4u, 16u}) {
      const ShareError error = share_error(shape, samples);
      std::printf("%s, %2u points: error of a pixel's share %.3f, of a 4x4 window's %.4f\n",
                  shape == LightShape::disc ? "disc  " : "sphere", samples, error.of_pixel, error.of_window);
      EXPECT_LT(error.of_pixel, samples == 4 ? 0.13 : 0.06);
      EXPECT_LT(error.of_window, error.of_pixel / 5);
    }
}

// The block of WIRE.md that a second implementation is tested with.
TEST(LightSamples, AreThoseOfTheWireDocument) {
  std::ifstream file(std::string(GNOMON_SOURCE_DIR) + "/protocol/WIRE.md");
  std::string line;
  while (std::getline(file, line) && line != "```hex sample_points") {
  }
  for (const LightArea& area : {LightArea{LightShape::rectangle, {0.5f, 0, 0}, {0, 0, 0.25f}},
                                LightArea{LightShape::disc, {0, 0.1f, 0}, {0, 0, 0.1f}},
                                LightArea{LightShape::sphere, {0.1f, 0, 0}, {0, 0.1f, 0}}}) {
    const std::vector<glm::vec3> points = sample_offsets(area, 4);
    for (uint32_t i = 0; i < 4; ++i) {
      ASSERT_TRUE(std::getline(file, line));
      std::istringstream bytes(line.substr(0, line.find('#')));
      std::array<uint8_t, 12> read{};
      std::string pair;
      for (uint8_t& byte : read) {
        ASSERT_TRUE(bytes >> pair) << line;
        byte = static_cast<uint8_t>(std::stoul(pair, nullptr, 16));
      }
      EXPECT_EQ(points[sample_pattern(5, 2) * 4 + i], std::bit_cast<glm::vec3>(read)) << line;
    }
  }
}

TEST(LightSamples, LieOnTheirShape) {
  for (const glm::vec3& p : sample_offsets({LightShape::rectangle, {0, 3, 0}, {1, 0, 0}}, 16)) {
    EXPECT_LT(std::abs(p.x), 1.0f);
    EXPECT_LT(std::abs(p.y), 3.0f);
    EXPECT_EQ(p.z, 0.0f);
  }
  for (const glm::vec3& p : sample_offsets({LightShape::disc, {0, 3, 0}, {3, 0, 0}}, 4))
    EXPECT_LT(glm::length(p), 3.0f);
  for (const glm::vec3& p : sample_offsets({}, 4)) EXPECT_EQ(p, glm::vec3(0.0f));
}

}  // namespace
}  // namespace gnomon::scenes::testing
