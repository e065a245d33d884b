// What operators have changed of lights: how changes of one light are joined, kept, and taken over from another node.
#include "daemon/scenes/changed_lights.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

namespace gnomon::daemon {
namespace {

using Place = ChangedLights::Place;

LightChange change_of(const char* text) { return parse_light_change(text).value(); }

std::vector<scenes::Light> two_lights() {
  std::vector<scenes::Light> lights(2);
  for (scenes::Light& light : lights) light.intensity = 40;
  return lights;
}

TEST(ChangedLights, ChangesOfALightAreJoined) {
  ChangedLights changed;
  ASSERT_TRUE(changed.add({"hall", 1}, change_of(R"({"on": false, "color": [1, 0, 0]})"), 5));
  EXPECT_EQ(changed.applied("hall", two_lights())[1].intensity, 0);
  ASSERT_TRUE(changed.add({"hall", 1}, change_of(R"({"intensity": 7})"), 6));
  const auto lights = changed.applied("hall", two_lights());
  EXPECT_EQ(lights[1].intensity, 7) << "what was said last of its brightness";
  EXPECT_EQ(lights[1].color, glm::vec3(1, 0, 0));
  EXPECT_EQ(lights[0].intensity, 40);
  EXPECT_EQ(changed.applied("attic", two_lights())[1].intensity, 40);
  ASSERT_TRUE(changed.add({"hall", 1}, change_of(R"({"on": true})"), 7));
  EXPECT_EQ(changed.applied("hall", two_lights())[1].intensity, 40);
}

TEST(ChangedLights, ALightGoesBackToItsFileAndIsKnownToHaveBeenChanged) {
  ChangedLights changed;
  ASSERT_TRUE(changed.add({"hall", 0}, change_of(R"({"intensity": 7, "color": [1, 0, 0]})"), 5));
  ASSERT_TRUE(changed.add({"hall", 0}, change_of(R"({"as_in_file": true})"), 6));
  EXPECT_EQ(changed.applied("hall", two_lights())[0].intensity, 40);
  ChangedLights late =
      ChangedLights::parse(R"({"lights": [{"scene": "hall", "light": 0, "at_ms": 5, "change": {"on": false}}]})")
          .value();
  EXPECT_EQ(late.take(changed), (std::vector{Place{"hall", 0}}));
  EXPECT_EQ(late.applied("hall", two_lights())[0].intensity, 40);
}

TEST(ChangedLights, OfTwoNodesTheNewerChangeIsTaken) {
  ChangedLights one, other;
  ASSERT_TRUE(one.add({"hall", 0}, change_of(R"({"intensity": 1})"), 10));
  ASSERT_TRUE(one.add({"hall", 1}, change_of(R"({"intensity": 1})"), 30));
  ASSERT_TRUE(other.add({"hall", 0}, change_of(R"({"intensity": 2})"), 20));
  ASSERT_TRUE(other.add({"hall", 1}, change_of(R"({"intensity": 2})"), 20));
  EXPECT_EQ(one.take(other), (std::vector{Place{"hall", 0}}));
  EXPECT_EQ(one.applied("hall", two_lights())[0].intensity, 2);
  EXPECT_EQ(one.applied("hall", two_lights())[1].intensity, 1);
  EXPECT_TRUE(one.take(other).empty()) << "it has them";
}

TEST(ChangedLights, AClockThatIsBehindDoesNotMakeAChangeOlder) {
  ChangedLights one, other;
  ASSERT_TRUE(one.add({"hall", 0}, change_of(R"({"intensity": 1})"), 1000));
  other.take(one);
  ASSERT_TRUE(one.add({"hall", 0}, change_of(R"({"intensity": 2})"), 10));
  EXPECT_EQ(other.take(one).size(), 1u);
  EXPECT_EQ(other.applied("hall", two_lights())[0].intensity, 2);
}

TEST(ChangedLights, AChangeAfterTheLatestDateThereIsCanBeReadAgain) {
  ChangedLights lights;
  for (int i = 0; i < 3; ++i)
    ASSERT_TRUE(lights.add({"temple", 0}, parse_light_change(R"({"on": false})").value(), int64_t{1} << 53));
  EXPECT_TRUE(ChangedLights::parse(lights.text()));
}

TEST(ChangedLights, WhatDoesNotFitTheSceneIsLeftOut) {
  ChangedLights changed;
  ASSERT_TRUE(changed.add({"hall", 2}, change_of(R"({"intensity": 1})"), 1));
  ASSERT_TRUE(changed.add({"hall", 1}, change_of(R"({"position": [0, 9, 0]})"), 1));
  auto lights = two_lights();
  lights[1].moved_by = 0;
  const auto shown = changed.applied("hall", lights);
  ASSERT_EQ(shown.size(), 2u);
  EXPECT_EQ(shown[1].position, lights[1].position) << "an animation moves it";
}

TEST(ChangedLights, AreReadAsTheyWereWritten) {
  const std::string file = testing::TempDir() + "changed_lights_" + std::to_string(getpid());
  EXPECT_TRUE(ChangedLights::read(file).value().lights().empty()) << "there is none at the first start";
  ChangedLights changed;
  const char* all =
      R"({"color":[0.5,0.25,0.0],"direction":[0.0,1.0,0.0],"intensity":7.5,"on":true,"position":[1.0,2.0,3.0],"range":9.0})";
  ASSERT_TRUE(changed.add({"a \"hall\"", 3}, change_of(all), 1'764'000'000'000));
  ASSERT_TRUE(changed.write(file));
  const auto read = ChangedLights::read(file);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->text(), changed.text());
  EXPECT_EQ(light_change_text(read->lights().begin()->second.change), all);
  unlink(file.c_str());
  EXPECT_FALSE(changed.write("/nowhere/at/all"));
}

TEST(ChangedLights, WhatIsNoListOfChangesIsRefused) {
  for (const char* wrong :
       {"", "[]", "{}", R"({"lights": 1})", R"({"lights": [1]})",
        R"({"lights": [{"scene": "hall", "light": 0, "at_ms": 1}]})",
        R"({"lights": [{"scene": "hall", "light": 10000, "at_ms": 1, "change": {}}]})",
        R"({"lights": [{"scene": "hall", "light": -1, "at_ms": 1, "change": {}}]})",
        R"({"lights": [{"scene": 7, "light": 0, "at_ms": 1, "change": {}}]})",
        R"({"lights": [{"scene": "hall", "light": 0, "at_ms": -1, "change": {}}]})",
        R"({"lights": [{"scene": "hall", "light": 0, "at_ms": 1, "change": {"colour": 1}}]})"}) {
    EXPECT_FALSE(ChangedLights::parse(wrong)) << wrong;
  }
}

}  // namespace
}  // namespace gnomon::daemon
