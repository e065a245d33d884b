// Light buffers answer bit for bit what brute force over all triangles answers.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "gpu/tracers/light_buffer/builder.h"
#include "gpu/tracers/light_buffer/footprint.h"
#include "gpu/tracers/light_buffer/query.h"
#include "tests/unit/gpu/light_buffer/soups.h"

namespace gnomon::test {
namespace {

namespace exact = gpu::exact;
namespace light_buffer = gpu::light_buffer;

struct Ends {
  uint32_t lit = 0, dark = 0;
  std::array<uint32_t, 3> by{};
};

Ends compare(const Soup& soup, const light_buffer::LightBuffer& buffer, Random& random, int points) {
  Ends ends;
  for (int q = 0; q < points; ++q) {
    const exact::SurfacePoint point = make_point(soup, random);
    const glm::vec3 camera = point.position + point.normal;
    const exact::ShadowSegment segment = exact::shadow_segment(camera, point, soup.light);
    if (!segment.traced) continue;
    const light_buffer::Answer answer = light_buffer::query(buffer, buffer.lights[0], soup.mesh, segment);
    const bool expected = !blocked(soup.mesh, segment);
    EXPECT_EQ(answer.lit, expected) << "end " << static_cast<int>(answer.end) << " point " << point.position.x
                                    << ' ' << point.position.y << ' ' << point.position.z;
    if (answer.lit != expected) return ends;
    ++(expected ? ends.lit : ends.dark);
    ++ends.by[static_cast<size_t>(answer.end)];
  }
  return ends;
}

constexpr int kTriangles[] = {3, 12, 40, 160};
constexpr int kPoints = 1000;

class Exactness : public testing::TestWithParam<std::tuple<Shape, Lamp>> {};

TEST_P(Exactness, EqualsBruteForce) {
  const auto [shape, lamp] = GetParam();
  Random random(static_cast<uint32_t>(shape) * 16 + static_cast<uint32_t>(lamp));
  Ends total;
  for (int scene = 0; scene < 12; ++scene) {
    const Soup soup = make_soup(shape, lamp, kTriangles[scene % 4], random);
    light_buffer::BuildSettings settings;
    settings.threads = 1;
    settings.detail.cost_per_byte = scene % 8 < 4 ? 3e-7 : 1e-5;
    settings.detail.finest_level = shape == Shape::touching ? 8 : 9;
    const light_buffer::LightBuffer buffer =
        light_buffer::build(soup.mesh, soup.bounds, std::span(&soup.light, 1), settings);
    const Ends ends = compare(soup, buffer, random, kPoints);
    if (HasFailure()) return;
    total.lit += ends.lit;
    total.dark += ends.dark;
    for (size_t e = 0; e < 3; ++e) total.by[e] += ends.by[e];
  }
  // The soups must ask something: both answers occur, and lists are walked.
  EXPECT_GT(total.lit, 50u);
  EXPECT_GT(total.dark, 50u);
  EXPECT_GT(total.by[static_cast<size_t>(light_buffer::End::list)], 50u);
  RecordProperty("near", static_cast<int>(total.by[0]));
  RecordProperty("cover", static_cast<int>(total.by[1]));
  RecordProperty("list", static_cast<int>(total.by[2]));
}

INSTANTIATE_TEST_SUITE_P(
    Soups, Exactness,
    testing::Combine(testing::Values(Shape::even, Shape::tiny, Shape::huge, Shape::slivers, Shape::edge_on,
                                     Shape::touching, Shape::sheets, Shape::astride, Shape::around, Shape::grid),
                     testing::Values(Lamp::point, Lamp::spot, Lamp::directional)),
    [](const auto& soup) { return name(std::get<0>(soup.param)) + "_" + name(std::get<1>(soup.param)); });

// A floor under the light, in two triangles: faces that look sideways see it too, though it reaches behind the light.
TEST(Footprint, IsBoundedWhereAFaceShowsAPartOfATriangleThatReachesBehindTheLight) {
  gpu::exact::TracedLight light{};
  const light_buffer::LightFaces faces = light_buffer::light_faces(light, {{-9, -1, -9}, {9, 1, 9}});
  size_t seen = 0;
  for (const light_buffer::Face& face : faces.faces) {
    const auto f = light_buffer::footprint(face, faces.diameter, {{{-9, -1, -9}, {9, -1, -8}, {0, -1, 9}}});
    if (!f) continue;
    ++seen;
    EXPECT_TRUE(f->bounded);
    EXPECT_LE(std::max({-f->box.u0, -f->box.v0, f->box.u1, f->box.v1}), 1.2);
  }
  EXPECT_EQ(seen, 5u) << "all but the face that looks up";
}

uint64_t cells_of(const light_buffer::LightBuffer& buffer, size_t faces) {
  return buffer.lights.size() * faces * light_buffer::kCellCount * sizeof(uint32_t);
}

// Many slivers that all point at the light: nothing divides them well.
class WorstCase : public testing::Test {
 protected:
  WorstCase() {
    Random random(11);
    soup_ = make_soup(Shape::edge_on, Lamp::point, 3000, random);
  }
  light_buffer::LightBuffer build() const {
    return light_buffer::build(soup_.mesh, soup_.bounds, std::span(&soup_.light, 1), settings_);
  }

  Soup soup_;
  light_buffer::BuildSettings settings_;
};

TEST_F(WorstCase, StaysWithinItsMemory) {
  const light_buffer::LightBuffer whole = build();
  const uint64_t cells = cells_of(whole, 6);
  settings_.budget_bytes = cells + (whole.statistics.bytes - cells) / 4;
  const light_buffer::LightBuffer kept = build();
  EXPECT_LE(kept.statistics.bytes, settings_.budget_bytes);
  EXPECT_GT(kept.statistics.bytes, settings_.budget_bytes / 2) << "and it uses what it may";
  Random random(12);
  EXPECT_GT(compare(soup_, kept, random, kPoints).dark, 50u);
}

TEST_F(WorstCase, StopsDividingWhereItsWorkWouldBeTooMuch) {
  const light_buffer::LightBuffer whole = build();
  settings_.most_work = whole.statistics.work / 4;
  const light_buffer::LightBuffer kept = build();
  EXPECT_LE(kept.statistics.work, 2 * settings_.most_work) << "as estimated beforehand";
  Random random(13);
  EXPECT_GT(compare(soup_, kept, random, kPoints).dark, 50u);
}

TEST(Build, SameBytesWithAnyNumberOfThreads) {
  Random random(7);
  const Soup soup = make_soup(Shape::even, Lamp::point, 250, random);
  light_buffer::BuildSettings one, three;
  one.threads = 1;
  three.threads = 3;
  const auto a = light_buffer::build(soup.mesh, soup.bounds, std::span(&soup.light, 1), one);
  const auto b = light_buffer::build(soup.mesh, soup.bounds, std::span(&soup.light, 1), three);
  ASSERT_EQ(a.leaves.size(), b.leaves.size());
  EXPECT_EQ(std::memcmp(a.leaves.data(), b.leaves.data(), a.leaves.size() * sizeof(a.leaves[0])), 0);
  EXPECT_EQ(a.entries, b.entries);
}

// The survey of what details take is a sample, and ends where limits are exceeded: both must not depend on threads.
TEST(Build, FillsABudgetThatSeveralLightsShareWithTheSameBytesWhateverTheThreads) {
  Random random(14);
  const Soup soup = make_soup(Shape::even, Lamp::point, 2500, random);
  std::vector<gpu::exact::TracedLight> lights(3, soup.light);
  lights[1].position =
      soup.bounds.min + 0.1f * (soup.bounds.max - soup.bounds.min);  // in a corner: most is on few faces
  lights[2].position = soup.bounds.max;
  light_buffer::BuildSettings settings;
  const light_buffer::LightBuffer whole = light_buffer::build(soup.mesh, soup.bounds, lights, settings);
  const uint64_t cells = cells_of(whole, 6);
  settings.budget_bytes = cells + (whole.statistics.bytes - cells) / 3;
  settings.threads = 1;
  const light_buffer::LightBuffer a = light_buffer::build(soup.mesh, soup.bounds, lights, settings);
  settings.threads = 3;
  const light_buffer::LightBuffer b = light_buffer::build(soup.mesh, soup.bounds, lights, settings);
  EXPECT_LE(a.statistics.bytes, settings.budget_bytes);
  EXPECT_GT(a.statistics.bytes - cells, (settings.budget_bytes - cells) * 8 / 10);
  EXPECT_EQ(a.grid, b.grid);
  ASSERT_EQ(a.leaves.size(), b.leaves.size());
  EXPECT_EQ(std::memcmp(a.leaves.data(), b.leaves.data(), a.leaves.size() * sizeof(a.leaves[0])), 0);
  EXPECT_EQ(a.entries, b.entries);
}

TEST(Build, TellsOfEachLightHowMuchOfItIsDone) {
  Random random(8);
  const Soup soup = make_soup(Shape::even, Lamp::point, 400, random);
  const std::vector<gpu::exact::TracedLight> lights(3, soup.light);
  std::vector<double> shares(lights.size());
  light_buffer::BuildSettings settings;
  settings.progress = [&](size_t light, double share) {
    EXPECT_GE(share, shares.at(light));
    EXPECT_EQ(std::count(shares.begin(), shares.begin() + static_cast<ptrdiff_t>(light), 1.0), light)
        << "one light after the other";
    shares[light] = share;
  };
  light_buffer::build(soup.mesh, soup.bounds, lights, settings);
  EXPECT_EQ(shares, std::vector<double>(lights.size(), 1.0));
}

TEST(Build, EndsSoonWhenItIsStopped) {
  Random random(9);
  const Soup soup = make_soup(Shape::even, Lamp::point, 400, random);
  const std::vector<gpu::exact::TracedLight> lights(1000, soup.light);
  std::stop_source stop;
  size_t begun = 0;
  light_buffer::BuildSettings settings;
  settings.stop = stop.get_token();
  settings.progress = [&](size_t light, double share) {
    begun = light;
    if (light == 1 && share > 0.3) stop.request_stop();
  };
  light_buffer::build(soup.mesh, soup.bounds, lights, settings);
  EXPECT_EQ(begun, 1u);
}

}  // namespace
}  // namespace gnomon::test
