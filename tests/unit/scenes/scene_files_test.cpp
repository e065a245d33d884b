// Real scenes, valid files of many tools and broken ones, each loaded in a process of its own. They live beside the
// repository, in ../shared/scenes; without them there is nothing to test here.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <sstream>

#include "scenes/loader.h"
#include "tests/unit/scenes/support/invariants.h"

namespace gnomon::scenes::testing {
namespace {

namespace fs = std::filesystem;

const fs::path kScenes = fs::path(GNOMON_SOURCE_DIR) / ".." / "shared" / "scenes";

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kSanitized = true;  // sanitizers reserve terabytes of addresses
#else
constexpr bool kSanitized = false;
#endif
constexpr rlim_t kAddressSpace = rlim_t{2} << 30;
constexpr long kPeakKilobytes = (kSanitized ? 2048 : 400) << 10;  // most of the files are of a few kilobytes
constexpr unsigned kMaxSeconds = kSanitized ? 120 : 10;           // long enough that only a hang exceeds it

std::vector<fs::path> files_in(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& file : fs::recursive_directory_iterator(folder)) {
    if (file.path().extension() == ".gltf" || file.path().extension() == ".glb") files.push_back(file.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

struct Outcome {
  bool ended_by_itself = false;
  bool loaded = false;
  std::string message;  // the error, or the broken promise
  long peak_kilobytes = 0;
};

[[noreturn]] void load_and_tell(const fs::path& file, int pipe_end) {
  alarm(kMaxSeconds);
  if (!kSanitized) {
    const rlimit limit{kAddressSpace, kAddressSpace};
    setrlimit(RLIMIT_AS, &limit);
  }
  const Result<ScenePtr> scene = load_scene(file);
  std::string text(1, scene ? 'L' : 'E');
  text += scene ? broken_promise(**scene) : scene.error().message;
  const ssize_t ignored = write(pipe_end, text.data(), text.size());
  _exit(ignored < 0);
}

Outcome load_apart(const fs::path& file) {
  int ends[2];
  if (pipe(ends) != 0) return {};
  const pid_t child = fork();
  if (child == 0) {
    close(ends[0]);
    load_and_tell(file, ends[1]);
  }
  close(ends[1]);
  std::string text;
  char block[4096];
  for (ssize_t got = 0; (got = read(ends[0], block, sizeof block)) > 0;)
    text.append(block, static_cast<size_t>(got));
  close(ends[0]);
  int status = 0;
  rusage used{};
  wait4(child, &status, 0, &used);
  Outcome outcome;
  outcome.ended_by_itself = WIFEXITED(status) && WEXITSTATUS(status) == 0 && !text.empty();
  outcome.loaded = !text.empty() && text[0] == 'L';
  outcome.message = text.empty() ? "" : text.substr(1);
  outcome.peak_kilobytes = used.ru_maxrss;
  return outcome;
}

void expect_modest(const Outcome& outcome, const fs::path& file) {
  EXPECT_TRUE(outcome.ended_by_itself) << file << " crashed or hung";
  EXPECT_EQ(outcome.message.find("not enough memory"), std::string::npos) << file;
  EXPECT_LT(outcome.peak_kilobytes, kPeakKilobytes) << file;
}

std::string content_of(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

// The names in the file's first "extensionsRequired" array.
std::vector<std::string> required_extensions(const fs::path& file) {
  const std::string text = content_of(file);
  const size_t key = text.find("\"extensionsRequired\"");
  if (key == std::string::npos) return {};
  const size_t end = text.find(']', key);
  std::istringstream list(text.substr(text.find('[', key) + 1, end - text.find('[', key) - 1));
  std::vector<std::string> names;
  for (std::string name; std::getline(list, name, ',');) {
    const size_t from = name.find('"');
    names.push_back(name.substr(from + 1, name.rfind('"') - from - 1));
  }
  return names;
}

struct Expected {
  std::string file;
  uint64_t triangles = 0;
  uint64_t lights = 0;
};

// The table of the scenes' README: | file | triangles | lights | ...
std::vector<Expected> table() {
  std::vector<Expected> rows;
  std::istringstream readme(content_of(kScenes / "README.md"));
  for (std::string line; std::getline(readme, line);) {
    std::istringstream cells(line);
    std::string cell[4];
    for (std::string& c : cell) std::getline(cells, c, '|');
    for (std::string& c : cell)
      c.erase(std::remove_if(c.begin(), c.end(), [](char k) { return k == ' ' || k == ','; }), c.end());
    if (fs::path(cell[1]).extension() == ".glb")
      rows.push_back({cell[1], std::stoull(cell[2]), std::stoull(cell[3])});
  }
  return rows;
}

class SceneFiles : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!fs::exists(kScenes / "README.md")) GTEST_SKIP() << "no scenes at " << kScenes << ": nothing was tested";
  }
};

TEST_F(SceneFiles, RealScenesHaveTheirTrianglesAndLights) {
  const std::vector<Expected> rows = table();
  ASSERT_FALSE(rows.empty());
  for (const Expected& row : rows) {
    const Result<ScenePtr> scene = load_scene(kScenes / row.file);
    ASSERT_TRUE(scene) << scene.error().message;
    EXPECT_EQ((*scene)->triangle_count, row.triangles) << row.file;
    EXPECT_EQ((*scene)->lights.size(), row.lights) << row.file;
    EXPECT_EQ(broken_promise(**scene), "") << row.file;
  }
}

TEST_F(SceneFiles, ValidFilesLoadOrNameTheExtensionThatTheyRequire) {
  const std::vector<fs::path> files = files_in(kScenes / "conformance");
  ASSERT_FALSE(files.empty());
  for (const fs::path& file : files) {
    const Outcome outcome = load_apart(file);
    expect_modest(outcome, file);
    if (outcome.loaded) {
      EXPECT_EQ(outcome.message, "") << file;
      continue;
    }
    const std::vector<std::string> required = required_extensions(file);
    const bool named = std::any_of(required.begin(), required.end(), [&](const std::string& name) {
      return outcome.message.find(name) != std::string::npos;
    });
    EXPECT_TRUE(named) << file << ": " << outcome.message;
  }
}

TEST_F(SceneFiles, BrokenFilesHarmNobody) {
  const std::vector<fs::path> files = files_in(kScenes / "malformed");
  ASSERT_FALSE(files.empty());
  int refused = 0;
  for (const fs::path& file : files) {
    const Outcome outcome = load_apart(file);
    expect_modest(outcome, file);
    EXPECT_EQ(outcome.loaded ? outcome.message : "", "") << file;
    refused += outcome.loaded ? 0 : 1;
    if (file.filename().string().rfind("hand_uri_", 0) == 0) {
      EXPECT_FALSE(outcome.loaded) << file << " reaches outside its folder";
    }
  }
  EXPECT_GT(refused, 0);
}

}  // namespace
}  // namespace gnomon::scenes::testing
