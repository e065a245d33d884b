#include "daemon/config/render_effects.h"

#include <gtest/gtest.h>

namespace gnomon::daemon {
namespace {

using Names = std::vector<std::string>;

RenderConfig with(Names passes, uint32_t max_samples = 16) {
  RenderConfig render;
  render.passes = std::move(passes);
  render.max_samples = max_samples;
  return render;
}

TEST(RenderEffects, AreBothUnlessTheListSaysOtherwise) {
  const Names both{"hard_shadows", "soft_shadows"}, hard{"hard_shadows"};
  EXPECT_EQ(effects_of(with({})), both);
  EXPECT_EQ(effects_of(with(both)), both);
  EXPECT_EQ(effects_of(with({"soft_shadows"})), both);
  EXPECT_EQ(effects_of(with(hard)), hard);
  EXPECT_EQ(effects_of(with({}, 1)), hard);
  EXPECT_EQ(most_samples(with(hard)), 1u);
  EXPECT_EQ(most_samples(with({}, 4)), 4u);
  EXPECT_TRUE(renderer_passes(with(both)).empty());
}

TEST(RenderEffects, TheRenderersOwnNamesStillMeanWhatTheyDid) {
  const Names former{"gbuffer", "trace", "pack", "readback"};
  EXPECT_EQ(renderer_passes(with(former)), former);
  EXPECT_EQ(effects_of(with(former)), (Names{"hard_shadows", "soft_shadows"}));
  EXPECT_EQ(renderer_passes(with({"hard_shadows", "sharpen"})), Names{"sharpen"}) << "for the renderer to refuse";
}

TEST(RenderEffects, ClientsMayInsistOnWhatRunsAndOnFormerNames) {
  const RenderConfig both = with({}), hard = with({"hard_shadows"});
  for (const char* name : {"hard_shadows", "soft_shadows", "gbuffer", "readback"}) EXPECT_TRUE(offers(both, name));
  EXPECT_FALSE(offers(both, "bloom"));
  EXPECT_TRUE(offers(hard, "hard_shadows"));
  EXPECT_FALSE(offers(hard, "soft_shadows"));
  EXPECT_FALSE(offers(with({"gbuffer", "trace"}), "pack"));
}

}  // namespace
}  // namespace gnomon::daemon
