// What is listed of folders from which clients may ask for files.
#include "daemon/scenes/scene_catalog.h"

#include <gtest/gtest.h>

#include "tests/unit/scenes/support/gltf_file.h"

namespace gnomon::daemon {
namespace {

using scenes::testing::ScratchFolder;

// Who may put files there must not keep the daemon from starting.
TEST(SceneCatalog, MoreFilesThanItTakesAreLeftOut) {
  const ScratchFolder folder;
  const auto file = folder.write("0.glb", std::string("scene"));
  for (size_t i = 1; i <= SceneCatalog::kMaxFiles; ++i) {
    std::filesystem::create_hard_link(file, folder.path() / (std::to_string(i) + ".glb"));
    if (i < SceneCatalog::kMaxFiles - 1) continue;
    ScenesConfig config;
    config.allow_files = {folder.path()};
    const auto catalog = SceneCatalog::read(config);
    ASSERT_TRUE(catalog) << catalog.error().message;
    EXPECT_EQ(catalog->sources().size(), std::min(i + 1, SceneCatalog::kMaxFiles));
    EXPECT_EQ(catalog->left_out().empty(), i + 1 <= SceneCatalog::kMaxFiles) << catalog->left_out();
  }
}

}  // namespace
}  // namespace gnomon::daemon
