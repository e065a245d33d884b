#include "daemon/render/light_change.h"

#include <gtest/gtest.h>

namespace gnomon::daemon {
namespace {

scenes::Light lamp() {
  scenes::Light light;
  light.position = {1, 2, 3};
  light.intensity = 40;
  return light;
}

TEST(LightChange, WhatIsLeftOutStays) {
  const auto change = parse_light_change(R"({"position": [0, 5, 0.5], "color": [1, 0, 0]})");
  ASSERT_TRUE(change) << change.error().message;
  const auto light = changed_light(lamp(), lamp(), *change);
  ASSERT_TRUE(light);
  EXPECT_EQ(light->position, glm::vec3(0, 5, 0.5f));
  EXPECT_EQ(light->color, glm::vec3(1, 0, 0));
  EXPECT_EQ(light->intensity, 40);
  EXPECT_EQ(changed_light(lamp(), lamp(), *parse_light_change("{}"))->position, lamp().position);
}

TEST(LightChange, OnGivesBackTheFilesIntensity) {
  const auto off = changed_light(lamp(), lamp(), *parse_light_change(R"({"on": false})"));
  ASSERT_TRUE(off);
  EXPECT_EQ(off->intensity, 0);
  EXPECT_EQ(changed_light(*off, lamp(), *parse_light_change(R"({"on": true})"))->intensity, 40);
  EXPECT_EQ(changed_light(*off, lamp(), *parse_light_change(R"({"on": true, "intensity": 7})"))->intensity, 7);
}

TEST(LightChange, DirectionsBecomeUnit) {
  const auto change = parse_light_change(R"({"direction": [0, -4, 3]})");
  ASSERT_TRUE(change);
  EXPECT_FLOAT_EQ(glm::length(*change->direction), 1);
}

TEST(LightChange, WhatAnAnimationMovesKeepsItsPlace) {
  scenes::Light moved = lamp();
  moved.moved_by = 0;
  EXPECT_FALSE(changed_light(moved, moved, *parse_light_change(R"({"position": [0, 0, 0]})")));
  EXPECT_TRUE(changed_light(moved, moved, *parse_light_change(R"({"intensity": 1})")));
}

TEST(LightChange, ErrorsNameTheMember) {
  const std::pair<const char*, const char*> wrong[] = {
      {"", "JSON object"},
      {"[1]", "JSON object"},
      {R"({"position": [1, 2]})", "position"},
      {R"({"position": [1, 2, 1e30]})", "position"},
      {R"({"direction": [0, 0, 0]})", "direction"},
      {R"({"color": [1, -1, 0]})", "color"},
      {R"({"intensity": "bright"})", "intensity"},
      {R"({"range": -1})", "range"},
      {R"({"on": 1})", "on"},
      {R"({"as_in_file": false})", "as_in_file"},
      {R"({"colour": [1, 1, 1]})", "colour: no such member"},
  };
  for (const auto& [body, part] : wrong) {
    const auto change = parse_light_change(body);
    ASSERT_FALSE(change) << body;
    EXPECT_NE(change.error().message.find(part), std::string::npos) << change.error().message;
  }
}

}  // namespace
}  // namespace gnomon::daemon
