#include "daemon/config/config.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>

namespace gnomon::daemon {
namespace {

const std::filesystem::path kFolder = std::filesystem::path(GNOMON_SOURCE_DIR) / "config";

std::string shipped_text() {
  std::ifstream file(kFolder / "gnomond.yaml");
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

struct Wrong {
  const char* name;
  std::string yaml;
  std::vector<std::string> says;  // texts that the error must contain
};

void PrintTo(const Wrong& wrong, std::ostream* out) { *out << wrong.name; }

class WrongConfig : public testing::TestWithParam<Wrong> {};

TEST_P(WrongConfig, NamesFileLineKeyAndWhatIsAllowed) {
  const auto config = parse_config(GetParam().yaml, "edge.yaml");
  ASSERT_FALSE(config);
  const std::string said = std::regex_replace(config.error().message, std::regex("(yaml:[0-9]+):[0-9]+"), "$1");
  for (const std::string& part : GetParam().says) {
    EXPECT_NE(said.find(part), std::string::npos) << config.error().message << "\nlacks " << part;
  }
}

INSTANTIATE_TEST_SUITE_P(
    Table, WrongConfig,
    testing::Values(
        Wrong{"unknown_section",
              "server: {}\nsevrer: {}\n",
              {"edge.yaml:2: sevrer: unknown key", "did you mean server?"}},
        Wrong{"unknown_key",
              "server:\n  control_prot: 1\n",
              {"edge.yaml:2: server.control_prot:", "did you mean control_port?", "listen, control_port"}},
        Wrong{"far_from_any_key",
              "log:\n  zzzzzzzzz: 1\n",
              {"edge.yaml:2: log.zzzzzzzzz: unknown key;", "level, format"}},
        Wrong{"wrong_type",
              "server:\n\n  control_port: http\n",
              {"edge.yaml:3: server.control_port: \"http\"", "an integer from 0 to 65535"}},
        Wrong{"quoted_number",
              "server: {control_port: \"80\"}\n",
              {"edge.yaml:1: server.control_port", "an integer"}},
        Wrong{"fraction",
              "encode: {threads: 1.5}\n",
              {"edge.yaml:1: encode.threads: \"1.5\"", "auto, or an integer from 1 to 64"}},
        Wrong{"too_large", "server: {data_port: 65536}\n", {"server.data_port: \"65536\"", "65535"}},
        Wrong{
            "beyond_64_bits", "server: {max_sessions: 99999999999999999999}\n", {"server.max_sessions", "1000000"}},
        Wrong{"negative", "server: {silence_timeout_ms: -1}\n", {"server.silence_timeout_ms: \"-1\"", "100 to"}},
        Wrong{"zero_threads", "encode: {threads: 0}\n", {"encode.threads: \"0\"", "1 to 64"}},
        Wrong{"nothing", "log:\n  level:\n", {"edge.yaml:2: log.level: nothing", "debug, info"}},
        Wrong{"not_a_choice", "log: {format: xml}\n", {"log.format: \"xml\"", "key_value, json"}},
        Wrong{"policy",
              "scheduler: {policy: fairest}\n",
              {"scheduler.policy: \"fairest\"", "fair, priority, deadline, round_robin"}},
        Wrong{"codec", "encode: {codec: zip}\n", {"encode.codec: \"zip\"", "tiles_lz4, tiles_context, raw32_lz4"}},
        Wrong{"address", "admin: {listen: localhost:80}\n", {"admin.listen: \"localhost:80\"", "IPv4 or IPv6"}},
        Wrong{"open_admin",
              "admin: {listen: 0.0.0.0}\n",
              {"admin.listen: 0.0.0.0 can be reached", "admin.token_file"}},
        Wrong{"token_in_clear",
              "admin: {listen: 0.0.0.0, token_file: secret}\n",
              {"admin.listen: 0.0.0.0 can be reached", "in clear", "admin.tls.certificate"}},
        Wrong{
            "half_an_identity", "admin: {tls: {key: k}}\n", {"admin.tls: certificate and key are needed together"}},
        Wrong{
            "demo_for_everybody",
            "server: {mode: demo, listen: 0.0.0.0}\n",
            {"edge.yaml:1: server.listen: 0.0.0.0 can be reached", "server.mode: demo", "server.insecure_listen"}},
        Wrong{"open_for_everybody",
              "server: {listen: '::'}\ntenants: [{name: lab}, {name: hall, open: true}]\n",
              {"edge.yaml:1: server.listen: :: can be reached", "tenant hall is open", "server.insecure_listen"}},
        Wrong{"list_for_value", "log: {level: [info]}\n", {"log.level: a list", "debug, info"}},
        Wrong{"value_for_section", "server: 5\n", {"edge.yaml:1: server: \"5\"", "a map with the keys mode"}},
        Wrong{"value_for_list",
              "tenants: lab\n",
              {"edge.yaml:1: tenants: \"lab\"", "a list of maps", "name, weight"}},
        Wrong{"value_in_list", "tenants:\n  - lab\n", {"edge.yaml:2: tenants: \"lab\"", "name, weight"}},
        Wrong{
            "map_for_list", "scenes: {allow_files: {a: b}}\n", {"scenes.allow_files: a map", "a list of folders"}},
        Wrong{"unknown_in_item",
              "tenants:\n  - name: lab\n    wieght: 2\n",
              {"edge.yaml:3: tenants.wieght", "mean weight?"}},
        Wrong{"nameless_tenant", "tenants:\n  - weight: 2\n", {"edge.yaml:2: tenants: name is needed"}},
        Wrong{"bad_name", "tenants: [{name: \"a b\"}]\n", {"tenants.name: \"a b\"", "letters"}},
        Wrong{"second_tenant",
              "tenants:\n  - name: lab\n  - name: lab\n",
              {"edge.yaml:3: tenants: a second tenant named lab"}},
        Wrong{"no_tenants", "tenants: []\n", {"edge.yaml:1: tenants", "at least one"}},
        Wrong{"ports_run_out",
              "server: {data_port: 65535, net_threads: 2}\n",
              {"edge.yaml:1: server.data_port: 65535", "at most 65534"}},
        Wrong{"scene_without_file",
              "scenes:\n  list:\n    - name: attic\n",
              {"edge.yaml:3: scenes.list: name and file"}},
        Wrong{"second_scene",
              "scenes:\n  list:\n    - {name: a, file: b}\n    - {name: a, file: c}\n",
              {"edge.yaml:4: scenes.list: a second scene named a"}},
        Wrong{"repeated_key", "log:\n  level: info\n  level: debug\n", {"edge.yaml:3: log.level: given twice"}},
        Wrong{"repeated_section", "log: {}\nserver: {}\nlog: {}\n", {"edge.yaml:3: log: given twice"}},
        Wrong{"no_yaml", "server:\n  listen: [\n", {"edge.yaml:3: not YAML"}},
        Wrong{"not_a_map", "- a\n- b\n", {"edge.yaml:1: a list", "server, web, admin, scenes"}}),
    [](const auto& instance) { return instance.param.name; });

TEST(Config, EmptyTextGivesTheDefaults) {
  const auto config = parse_config("", "empty.yaml");
  ASSERT_TRUE(config) << config.error().message;
  EXPECT_EQ(config->server.control_port, Config{}.server.control_port);
  ASSERT_EQ(config->tenants.size(), 1u);
  EXPECT_EQ(config->tenants[0].name, kDefaultTenant);
}

TEST(Config, ReadsValuesOfEveryKind) {
  const auto config = parse_config(
      "server: {listen: '::1', silence_timeout_ms: 1500}\n"
      "render: {passes: [a, b]}\n"
      "encode: {codec: raw32_lz4}\n"
      "tenants: [{name: lab, weight: 3}, {name: hall}]\n"
      "log: {format: json}\n",
      "kinds.yaml");
  ASSERT_TRUE(config) << config.error().message;
  EXPECT_EQ(config->server.listen, "::1");
  EXPECT_EQ(config->server.silence_timeout, std::chrono::milliseconds(1500));
  EXPECT_EQ(config->render.passes, (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(config->encode.codec, protocol::CodecId::raw32_lz4);
  ASSERT_EQ(config->tenants.size(), 2u);
  EXPECT_EQ(config->tenants[0].weight, 3u);
  EXPECT_EQ(config->tenants[1].name, "hall");
  EXPECT_EQ(config->log.format, log::Format::json);
}

TEST(Config, OverridesWinOverTheFileAndTheLaterOverTheEarlier) {
  const auto config = parse_config("server: {control_port: 1, data_port: 2}\n", "edge.yaml",
                                   {"server.control_port=3", "server.control_port=4", "tenants=[{name: lab}]"});
  ASSERT_TRUE(config) << config.error().message;
  EXPECT_EQ(config->server.control_port, 4);
  EXPECT_EQ(config->server.data_port, 2);
  EXPECT_EQ(config->tenants[0].name, "lab");
}

TEST(Config, OverridesAreCheckedTheSameWay) {
  const auto refused = [](const std::string& text) {
    const auto config = parse_config("", "edge.yaml", {text});
    return config ? std::string("accepted") : config.error().message;
  };
  EXPECT_NE(refused("server.control_prot=3").find("--set server.control_prot=3: server.control_prot: unknown key"),
            std::string::npos);
  EXPECT_NE(refused("server.control_port=x").find("an integer from 0 to 65535"), std::string::npos);
  EXPECT_NE(refused("server.control_port").find("key.path=value"), std::string::npos);
  EXPECT_NE(refused("=3").find("key.path=value"), std::string::npos);
  EXPECT_NE(refused("server=").find("accepted"), std::string::npos);  // an empty section sets nothing
  EXPECT_NE(refused("server..listen=3").find("unknown key"), std::string::npos);
  EXPECT_NE(refused("log.level=[").find("not YAML"), std::string::npos);
}

TEST(Config, DamagedTextNeverCrashes) {
  const std::string text = shipped_text();
  ASSERT_FALSE(text.empty());
  for (size_t length = 0; length <= text.size(); length += 7) (void)parse_config(text.substr(0, length), "cut");
  for (size_t i = 0; i < text.size(); i += 11) {
    std::string damaged = text;
    damaged[i] = static_cast<char>(damaged[i] ^ 0x15);
    (void)parse_config(damaged, "damaged");
  }
}

// A line of the shipped file, read without yaml-cpp: "  - name: lab  # who" has the key `name` at indentation 2.
struct Line {
  size_t indent = 0;
  std::string key;    // empty if the line has none
  std::string value;  // the rest of the line, comment included
};

// A commented-out example documents its keys too.
Line line_of(std::string text) {
  const size_t sign = text.find_first_not_of(' ');
  if (sign != std::string::npos && sign > 0 && text[sign] == '#') text[sign] = ' ';
  Line line;
  line.indent = std::min(text.find_first_not_of(' '), text.size());
  const bool item = text.compare(line.indent, 2, "- ") == 0;
  const size_t begin = line.indent + (item ? 2 : 0);
  const size_t colon = text.find(':', begin);
  if (colon == std::string::npos || text.find_first_not_of("abcdefghijklmnopqrstuvwxyz_0123456789", begin) != colon)
    return line;
  line.key = text.substr(begin, colon - begin);
  line.value = text.substr(colon + 1);
  return line;
}

std::vector<Line> lines_of(const std::string& text) {
  std::vector<Line> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line_of(line));
  return lines;
}

// Dotted keys, by the file's own indentation.
std::vector<std::string> keys_in(const std::string& text) {
  std::vector<std::string> keys;
  std::string section, list, nested;
  for (const Line& line : lines_of(text)) {
    if (line.key.empty()) continue;
    if (line.indent == 0) {
      section = line.key;
      list.clear();
    } else if (line.key == "list" || line.key == "tls") {
      list = "." + line.key;
    } else if (line.key == "moving") {
      nested = ".moving";
    } else {
      if (line.indent < 10) nested.clear();
      keys.push_back(section + (line.indent >= 4 ? list : "") + nested + "." + line.key);
    }
  }
  return keys;
}

TEST(MovingNodes, AreReadAndChecked) {
  const auto parse = [](const std::string& moving) {
    return parse_config("scenes: {list: [{name: a, file: a.glb, moving: [" + moving + "]}]}", "edge.yaml");
  };
  const auto config = parse("{node: fan, spin: [0, 0.5, 0], period_ms: 900}, {node: cart, shift: [2, 0, -1]}");
  ASSERT_TRUE(config) << config.error().message;
  const auto& moving = config->scenes.list.at(0).moving;
  ASSERT_EQ(moving.size(), 2u);
  EXPECT_EQ(moving[0].node, "fan");
  EXPECT_EQ(moving[0].spin, (std::vector<float>{0, 0.5f, 0}));
  EXPECT_EQ(moving[0].period.count(), 900);
  EXPECT_EQ(moving[1].shift, (std::vector<float>{2, 0, -1}));
  for (const char* wrong :
       {"{spin: [0, 1, 0]}", "{node: fan}", "{node: fan, spin: [0, 1]}", "{node: fan, spin: [0, 0, 0]}",
        "{node: fan, spin: [a, b, c]}", "{node: fan, spin: [0, 1, 0], shift: [1, 0, 0]}",
        "{node: fan, spin: [0, 1, 0], speed: 4}"})
    EXPECT_FALSE(parse(wrong)) << wrong;
}

TEST(ShippedConfig, DocumentsEveryKeyWithItsDefault) {
  const std::string text = shipped_text();
  const auto documented = keys_in(text);
  for (const std::string& key : known_keys()) {
    EXPECT_NE(std::find(documented.begin(), documented.end(), key), documented.end())
        << key << " is not documented";
  }
  const auto config = parse_config(text, "gnomond.yaml");
  ASSERT_TRUE(config) << config.error().message;
  auto examples = *config;
  examples.scenes.list = Config{}.scenes.list;
  examples.tenants = Config{}.tenants;
  EXPECT_EQ(changed_keys(examples, Config{}), std::vector<std::string>());
}

TEST(Config, AQuantumIsANumberOrAuto) {
  const auto parse = [](const char* quantum) {
    return parse_config(std::string("scheduler: {quantum_us: ").append(quantum).append("}"), "edge.yaml");
  };
  EXPECT_EQ(parse("0")->scheduler.quantum, std::chrono::microseconds(0));
  EXPECT_EQ(parse("2500")->scheduler.quantum, std::chrono::microseconds(2500));
  EXPECT_EQ(parse("auto")->scheduler.quantum, std::nullopt);
  for (const char* wrong : {"-1", "1000001", "often", "''", "[4]"}) EXPECT_FALSE(parse(wrong)) << wrong;
}

TEST(Config, TheEarlierNameOfAKeyIsReadAndShownNoMore) {
  const auto config = parse_config("scheduler: {slice_us: 2500}\n", "edge.yaml");
  ASSERT_TRUE(config) << config.error().message;
  EXPECT_EQ(config->scheduler.quantum, std::chrono::microseconds(2500));
  EXPECT_FALSE(parse_config("scheduler: {slice_us: often}\n", "edge.yaml"));
  const auto known = known_keys();
  EXPECT_EQ(std::count(known.begin(), known.end(), "scheduler.slice_us"), 0);
  EXPECT_EQ(std::count(known.begin(), known.end(), "scheduler.quantum_us"), 1);
}

TEST(Config, AnAdminServerWithATokenAndTlsListensAnywhere) {
  const auto config =
      parse_config("admin: {listen: '::', token_file: secret, tls: {certificate: c, key: k}}\n", "edge.yaml");
  ASSERT_TRUE(config) << config.error().message;
  EXPECT_EQ(config->admin.token_file, "secret");
  EXPECT_EQ(config->admin.tls.key, "k");
  EXPECT_TRUE(parse_config("admin: {listen: '::1'}\n", "edge.yaml"));
  EXPECT_TRUE(parse_config("admin: {listen: 127.8.9.1}\n", "edge.yaml"));
}

TEST(Config, TheAdminServerShowsTheClientsCertificateIfItHasNoOtherOne) {
  const std::string server = "server: {tls: {certificate: a.pem, key: b.pem}}\n";
  const auto shared = parse_config(server + "admin: {listen: '::', token_file: secret}\n", "edge.yaml");
  ASSERT_TRUE(shared) << shared.error().message;
  EXPECT_EQ(shared->admin.tls, (AdminTlsConfig{"a.pem", "b.pem"}));
  const auto own = parse_config(server + "admin: {tls: {certificate: c, key: k}}\n", "edge.yaml");
  ASSERT_TRUE(own) << own.error().message;
  EXPECT_EQ(own->admin.tls, (AdminTlsConfig{"c", "k"}));
}

TEST(Config, TheOperatorsSocketIsInItsUsualPlaceElsewhereOrNowhere) {
  EXPECT_EQ(Config().admin.socket, kUsualAdminSocket);
  EXPECT_EQ(parse_config("admin: {socket: ''}\n", "edge.yaml")->admin.socket, "");
  auto config = parse_config("admin: {socket: run/admin.sock}\n", "edge.yaml");
  ASSERT_TRUE(find_files(*config, "/etc/gnomon", "/usr/share").empty());
  EXPECT_EQ(config->admin.socket, "/etc/gnomon/run/admin.sock");
  auto usual = parse_config("admin: {socket: auto}\n", "edge.yaml");
  ASSERT_TRUE(find_files(*usual, "/etc/gnomon", "/usr/share").empty());
  EXPECT_EQ(usual->admin.socket, kUsualAdminSocket) << "no file beside the configuration";
}

TEST(ShippedConfig, EveryKeyInItIsKnownAndCommented) {
  const auto known = known_keys();
  for (const std::string& key : keys_in(shipped_text())) {
    EXPECT_NE(std::find(known.begin(), known.end(), key), known.end()) << key;
  }
  for (const Line& line : lines_of(shipped_text())) {
    const bool sets_a_value = line.indent > 0 && !line.key.empty() && !line.value.empty();
    const bool second_of_its_kind = line.value.find("temple") != std::string::npos || line.value == " default";
    if (sets_a_value && !second_of_its_kind) {
      EXPECT_NE(line.value.find(" # "), std::string::npos) << "no comment: " << line.key;
    }
  }
}

TEST(ShippedConfig, ExamplesAreValid) {
  for (const auto& entry : std::filesystem::directory_iterator(kFolder / "examples")) {
    const auto config = read_config(entry.path());
    EXPECT_TRUE(config) << config.error().message;
  }
}

TEST(SceneFiles, AreFoundBesideTheConfigurationThenInShare) {
  const auto folder = std::filesystem::temp_directory_path() / ("gnomon_config_test_" + std::to_string(getpid()));
  std::filesystem::create_directories(folder / "etc");
  std::filesystem::create_directories(folder / "share");
  for (const char* file : {"etc/both.glb", "share/both.glb", "share/only.glb"}) std::ofstream(folder / file) << "x";
  auto config =
      parse_config("scenes:\n  list: [{name: a, file: both.glb}, {name: b, file: only.glb}]\n", "edge.yaml");
  ASSERT_TRUE(config);
  const auto found = find_files(*config, folder / "etc", folder / "share");
  ASSERT_TRUE(found.empty()) << found.front().message;
  EXPECT_EQ(config->scenes.list[0].file, folder / "etc/both.glb");
  EXPECT_EQ(config->scenes.list[1].file, folder / "share/only.glb");

  auto missing =
      parse_config("scenes:\n  list:\n  - {name: a, file: none.glb}\n  - {name: b, file: only.glb}\n", "edge.yaml");
  ASSERT_TRUE(missing);
  const auto errors = find_files(*missing, folder / "etc", folder / "share");
  ASSERT_EQ(errors.size(), 1u);
  EXPECT_EQ(missing->scenes.list[1].file, folder / "share/only.glb") << "the others are found all the same";
  for (const std::string& part : std::vector<std::string>{"edge.yaml:3:5: scenes.list", "none.glb",
                                                          (folder / "etc").string(), (folder / "share").string()}) {
    EXPECT_NE(errors[0].message.find(part), std::string::npos) << errors[0].message;
  }
  std::filesystem::remove_all(folder);
}

TEST(Config, ATenantsPlacesAreItsShareANumberOrAll) {
  const auto config = parse_config(
      "tenants: [{name: a}, {name: b, max_sessions: auto}, {name: c, max_sessions: 0}, {name: d, max_sessions: "
      "7}]\n",
      "edge.yaml");
  ASSERT_TRUE(config) << config.error().message;
  EXPECT_EQ(config->tenants[0].max_sessions, std::nullopt);
  EXPECT_EQ(config->tenants[1].max_sessions, std::nullopt);
  EXPECT_EQ(config->tenants[2].max_sessions, 0u);
  EXPECT_EQ(config->tenants[3].max_sessions, 7u);
}

TEST(Config, RevocationListsNeedAnAuthority) {
  const auto config = parse_config("server: {tls: {client_crl: crl.pem}}\n", "edge.yaml");
  ASSERT_FALSE(config);
  EXPECT_NE(config.error().message.find("server.tls.client_ca"), std::string::npos) << config.error().message;
}

}  // namespace
}  // namespace gnomon::daemon
