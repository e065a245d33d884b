// What operators change of lights: clients hear of it, also those that come when the scene or the daemon is another one.
#include <gtest/gtest.h>

#include "daemon/ctl/admin_client.h"
#include "tests/unit/daemon/net/served.h"

namespace gnomon::daemon {
namespace {

class AdminLights : public Served {
 protected:
  ctl::AdminClient admin() { return ctl::AdminClient({.address = "unix:" + daemon_->admin().socket().string()}); }
  std::string refusal_of(const std::string& path) {
    const auto answer = admin().post(path);
    return answer ? "done: " + *answer : answer.error().message;
  }
  static protocol::Hello hello(const std::string& scene) {
    protocol::Hello hello = TestClient::hello(scene);
    hello.features |= protocol::kFeatureMoments;
    return hello;
  }
};

TEST_F(AdminLights, AChangedLightIsKnownToWhoeverLoadsTheSceneLater) {
  config_.scenes.lights_file = folder_ / "lights.json";
  for (const bool after_restart : {false, true}) {
    start();
    if (!after_restart) {
      ASSERT_TRUE(admin().post("/scenes/another.gltf/lights/0", {{"intensity", 7}})) << "which nobody has loaded";
      EXPECT_EQ(refusal_of("/scenes/nothing/lights/0"), "the configuration has no such scene");
    }
    TestClient c = client();
    ASSERT_TRUE(c.join(hello("another.gltf")));
    ASSERT_EQ(c.welcome().scene.lights.size(), 1u);
    EXPECT_EQ(c.welcome().scene.lights[0].intensity, 7) << (after_restart ? "restarted" : "");
    EXPECT_GT(c.welcome().lights_version, 0u);
    daemon_.reset();
  }
}

TEST_F(AdminLights, ANodeTakesOverWhatOthersKnowOfLights) {
  start();
  TestClient c = client();
  ASSERT_TRUE(c.join(hello(kScene)));
  ASSERT_TRUE(admin().post("/scenes/triangle/lights/0", {{"color", {1, 0, 0}}, {"at_ms", 1000}}));
  ASSERT_TRUE(c.receive_a<protocol::LightsChanged>());
  nlohmann::json others = *admin().get("/lights");
  EXPECT_EQ(others.at("lights").at(0).at("at_ms"), 1000);
  others["lights"][0]["change"] = {{"intensity", 7}};
  EXPECT_EQ(*admin().post("/lights", others), "changed lights that were not known: 0") << "as old as what it has";
  others["lights"][0]["at_ms"] = 1001;
  EXPECT_EQ(*admin().post("/lights", others), "changed lights that were not known: 1");
  const auto changed = c.receive_a<protocol::LightsChanged>();
  ASSERT_TRUE(changed);
  EXPECT_EQ(changed->lights.at(0).intensity, 7);
  EXPECT_EQ(changed->lights.at(0).color[1], 1) << "the change before is none any more";
  ASSERT_TRUE(admin().post("/scenes/triangle/lights/0", {{"as_in_file", true}}));
  const auto back = c.receive_a<protocol::LightsChanged>();
  ASSERT_TRUE(back);
  EXPECT_EQ(back->lights.at(0).intensity, c.welcome().scene.lights.at(0).intensity);
  EXPECT_EQ(refusal_of("/lights"), "there is no JSON object with a list of lights");
}

}  // namespace
}  // namespace gnomon::daemon
