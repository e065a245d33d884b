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

const Names kAll{"hard_shadows", "soft_shadows", "ambient_occlusion"};

TEST(RenderEffects, AreAllUnlessTheListSaysOtherwise) {
  const Names both{"hard_shadows", "soft_shadows"}, hard{"hard_shadows"},
      occluded{"hard_shadows", "ambient_occlusion"};
  EXPECT_EQ(effects_of(with({})), kAll);
  EXPECT_EQ(effects_of(with(kAll)), kAll);
  EXPECT_EQ(effects_of(with(both)), both);
  EXPECT_EQ(effects_of(with({"soft_shadows"})), both);
  EXPECT_EQ(effects_of(with({"ambient_occlusion"})), occluded);
  EXPECT_EQ(effects_of(with(hard)), hard);
  EXPECT_EQ(effects_of(with({}, 1)), occluded);
  EXPECT_EQ(most_samples(with(hard)), SampleCounts{});
  EXPECT_EQ(most_samples(with(both)), SampleCounts{16});
  EXPECT_EQ(most_samples(with({}, 4)), (SampleCounts{4, Occlusion::full}));
  EXPECT_TRUE(renderer_passes(with(kAll)).empty());
  RenderConfig none = with({});
  none.max_occlusion = Occlusion::none;
  EXPECT_EQ(effects_of(none), both);
}

TEST(RenderEffects, TheRenderersOwnNamesStillMeanWhatTheyDid) {
  const Names former{"gbuffer", "trace", "pack", "readback"};
  EXPECT_EQ(renderer_passes(with(former)), former);
  EXPECT_EQ(effects_of(with(former)), kAll);
  EXPECT_EQ(renderer_passes(with({"hard_shadows", "sharpen"})), Names{"sharpen"}) << "for the renderer to refuse";
}

TEST(RenderEffects, ClientsMayInsistOnWhatRunsAndOnFormerNames) {
  const RenderConfig all = with({}), hard = with({"hard_shadows"});
  for (const char* name : {"hard_shadows", "soft_shadows", "ambient_occlusion", "gbuffer", "readback"})
    EXPECT_TRUE(offers(all, name));
  EXPECT_FALSE(offers(all, "bloom"));
  EXPECT_TRUE(offers(hard, "hard_shadows"));
  EXPECT_FALSE(offers(hard, "soft_shadows"));
  EXPECT_FALSE(offers(hard, "ambient_occlusion"));
  EXPECT_FALSE(offers(with({"gbuffer", "trace"}), "pack"));
}

}  // namespace
}  // namespace gnomon::daemon
