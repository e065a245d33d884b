// What reading a configuration says beside its values: every mistake and where it stands, and what a reload cannot take.
#include <gtest/gtest.h>

#include "daemon/config/config.h"

namespace gnomon::daemon {
namespace {

TEST(ConfigReading, SaysAllThatIsWrongWithLineAndColumn) {
  const ConfigReading reading =
      examine_text("server:\n  control_port: http\n  net_threads: 0\nlog: {levle: info, format: xml}\n",
                   "edge.yaml", {"encode.threads=many"});
  std::string said;
  for (const Error& error : reading.errors) said += error.message.substr(0, error.message.find(": \"")) + "\n";
  EXPECT_EQ(
      said.find("edge.yaml:2:3: server.control_port\nedge.yaml:3:3: server.net_threads\nedge.yaml:4:7: log.levle"),
      0u)
      << said;
  EXPECT_NE(said.find("\nedge.yaml:4:20: log.format\n--set encode.threads=many: encode.threads"), std::string::npos)
      << said;
  EXPECT_TRUE(reading.is_mistaken("server.control_port"));
  EXPECT_TRUE(reading.is_mistaken("log.level")) << "which was meant";
  EXPECT_FALSE(reading.is_mistaken("server.listen"));
}

TEST(ConfigReading, NothingIsConcludedFromAMistake) {
  const ConfigReading reading =
      examine_text("server: {mode: dmo, listen: 0.0.0.0}\ntenants:\n  - weight: 0\n", "edge.yaml");
  EXPECT_EQ(reading.errors.size(), 2u) << "not that everybody gets in, nor that there is no tenant";
}

TEST(ConfigReading, AnErrorGetsThePlaceOfItsKeyOrOfWhatThatIsIn) {
  const auto config =
      parse_config("server:\n  tls: {key: k, certificate: c}\ntenants:\n  - {name: lab, weight: 2}\n", "edge.yaml",
                   {"log.level=debug"});
  ASSERT_TRUE(config) << config.error().message;
  const auto place = [&](const std::string& text) { return placed(*config, Error{text}).message; };
  EXPECT_EQ(place("server.tls.key: gone"), "edge.yaml:2:9: server.tls.key: gone");
  EXPECT_EQ(place("server.listen: gone"), "edge.yaml:1:1: server.listen: gone");
  EXPECT_EQ(place("tenants.lab.token_sha256_file: gone"), "edge.yaml:4:5: tenants.lab.token_sha256_file: gone");
  EXPECT_EQ(place("log.level: gone"), "--set log.level=debug: log.level: gone");
  EXPECT_EQ(place("render.device: gone"), "edge.yaml: render.device: gone");
  EXPECT_EQ(place("edge.yaml:2:9: server.tls.key: gone"), "edge.yaml:2:9: server.tls.key: gone");
}

TEST(ConfigReading, ARestartIsNeededForWhatARunningDaemonCannotChange) {
  Config running, next;
  EXPECT_TRUE(restart_keys(next, running).empty());
  next.scheduler.policy = "priority";
  next.tenants[0].weight = 7;
  next.server.max_sessions = 1;
  next.server.tls.key = "k";
  next.scenes.list = {{"a", "a.glb", ""}};
  next.scenes.allow_files = {"files"};
  next.log.level = log::Level::debug;
  next.log.format = log::Format::json;
  next.render.cache_mb = 1;
  EXPECT_TRUE(restart_keys(next, running).empty());
  next.server.control_port = 1;
  next.render.tracer = "bvh";
  next.scenes.clock_hz = 1;
  EXPECT_EQ(restart_keys(next, running),
            (std::vector<std::string>{"server.control_port", "scenes.clock_hz", "render.tracer"}));
}

// It stands in a page as it is.
TEST(ConfigReading, ASecondDocumentIsAMistake) {
  const auto parsed = parse_config("server: {mode: demo}\n---\nserver: {max_sesions: 3}\n", "edge.yaml");
  ASSERT_FALSE(parsed);
  EXPECT_NE(parsed.error().message.find("edge.yaml:3"), std::string::npos) << parsed.error().message;
  EXPECT_NE(parsed.error().message.find("a second YAML document"), std::string::npos) << parsed.error().message;
  EXPECT_TRUE(parse_config("---\nserver: {mode: demo}\n", "edge.yaml"));
  EXPECT_TRUE(parse_config("# nothing\n", "edge.yaml"));
}

TEST(ConfigReading, ASlipInAnEffectsNameIsAnsweredWithEffects) {
  const auto parsed = parse_config("render: {passes: [hard_shadows, soft_shadow]}\n", "edge.yaml");
  ASSERT_FALSE(parsed);
  EXPECT_NE(parsed.error().message.find("did you mean soft_shadows?"), std::string::npos) << parsed.error().message;
}

TEST(ConfigReading, AFleetsNameIsADomain) {
  for (const char* name : {"gnomon.example", "a", "a-1.example", ""}) {
    const auto config = parse_config("fleet: {name: '" + std::string(name) + "'}\n", "edge.yaml");
    ASSERT_TRUE(config) << config.error().message;
    EXPECT_EQ(config->fleet.name, name);
  }
  for (const std::string name : {"Gnomon.example", ".example", "example.", "-a", "\"><script>", "gnomon example"}) {
    const auto config = parse_config("fleet: {name: '" + name + "'}\n", "edge.yaml");
    ASSERT_FALSE(config) << name;
    EXPECT_NE(config.error().message.find("fleet.name"), std::string::npos) << config.error().message;
  }
  EXPECT_FALSE(parse_config("fleet: {name: " + std::string(240, 'a') + "}\n", "edge.yaml"));
}

}  // namespace
}  // namespace gnomon::daemon
