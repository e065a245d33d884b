// Light buffers of area lights count bit for bit what brute force over all triangles counts, from points anywhere to
// points anywhere within the light.
#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <limits>

#include "gpu/tracers/light_buffer/builder.h"
#include "gpu/tracers/light_buffer/footprint.h"
#include "gpu/tracers/light_buffer/query.h"
#include "tests/unit/gpu/light_buffer/soups.h"

namespace gnomon::test {
namespace {

namespace exact = gpu::exact;
namespace light_buffer = gpu::light_buffer;

constexpr size_t kSamples = 16;
constexpr int kTriangles[] = {3, 40, 12, 80};
constexpr int kPoints = 400;

float uniform(Random& random, float low, float high) {
  return std::uniform_real_distribution<float>(low, high)(random);
}

// Most within the light's ball, some on it, and its middle.
std::array<glm::vec3, kSamples> make_samples(const exact::TracedLight& light, Random& random) {
  std::array<glm::vec3, kSamples> samples;
  for (size_t i = 0; i < kSamples; ++i) {
    const glm::vec3 way(uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1));
    const float share = i == 0 ? 0.0f : i % 3 == 0 ? 0.9999f : uniform(random, 0, 0.9999f);
    samples[i] = light.position + way / std::max(glm::length(way), 1e-6f) * (share * light.radius);
  }
  return samples;
}

struct Ends {
  uint32_t all = 0, none = 0, some = 0;
  std::array<uint32_t, 3> by{};
};

void compare(const Soup& soup, const light_buffer::LightBuffer& buffer, Random& random, Ends& ends) {
  for (int q = 0; q < kPoints; ++q) {
    const exact::SurfacePoint point = make_point(soup, random);
    const exact::ShadowSegment middle = exact::shadow_segment(point.position + point.normal, point, soup.light);
    if (!middle.traced) continue;
    const auto samples = make_samples(soup.light, random);
    uint32_t expected = 0;
    for (const glm::vec3& sample : samples) {
      const exact::ShadowSegment segment = exact::sample_segment(middle.origin, point.normal, sample);
      expected += segment.traced && !blocked(soup.mesh, segment);
    }
    const light_buffer::AreaAnswer answer =
        light_buffer::query_area(buffer, buffer.lights[0], soup.mesh, point, middle.origin, samples);
    ASSERT_EQ(answer.seen, expected) << "end " << static_cast<int>(answer.end) << " point " << point.position.x
                                     << ' ' << point.position.y << ' ' << point.position.z << " radius "
                                     << soup.light.radius;
    ++(expected == kSamples ? ends.all : expected == 0 ? ends.none : ends.some);
    ++ends.by[static_cast<size_t>(answer.end)];
  }
}

class AreaExactness : public testing::TestWithParam<std::tuple<Shape, Lamp>> {};

TEST_P(AreaExactness, EqualsBruteForce) {
  const auto [shape, lamp] = GetParam();
  Random random(1000 + static_cast<uint32_t>(shape) * 16 + static_cast<uint32_t>(lamp));
  Ends total;
  for (int scene = 0; scene < 8; ++scene) {
    Soup soup = make_soup(shape, lamp, kTriangles[scene % 2 + 2 * (scene / 4 % 2)], random);
    const float size = glm::distance(soup.bounds.min, soup.bounds.max);
    soup.light.radius = size * std::array{0.002f, 0.02f, 0.1f, 1e-5f}[static_cast<size_t>(scene / 2)];
    light_buffer::BuildSettings settings;
    settings.threads = 1;
    settings.most_work = 3'000'000;
    settings.detail.cost_per_byte = scene % 2 == 0 ? 3e-7 : 1e-5;
    settings.detail.finest_level = 8;
    const light_buffer::LightBuffer buffer =
        light_buffer::build(soup.mesh, soup.bounds, std::span(&soup.light, 1), settings);
    compare(soup, buffer, random, total);
    if (HasFatalFailure()) return;
  }
  // The soups must ask something: all answers occur, and lists are walked.
  EXPECT_GT(total.all + total.some, 50u);
  EXPECT_GT(total.none, 5u);
  EXPECT_GT(total.some, 10u);
  EXPECT_GT(total.by[static_cast<size_t>(light_buffer::End::list)], 50u);
  std::printf("near %u, cover %u, list %u; all %u, none %u, some %u\n", total.by[0], total.by[1], total.by[2],
              total.all, total.none, total.some);
}

// Leaves something in the memory where the next call has its variables.
[[gnu::noinline]] void fill_stack() {
  std::array<volatile double, 1024> left;
  for (volatile double& number : left) number = std::numeric_limits<double>::quiet_NaN();
}

// Edges that were whatever the stack had left a triangle out of lists, here and there.
TEST(AreaFootprint, OfATriangleInThePlaneOfTheLightIsBoundedByItsBoxAlone) {
  exact::TracedLight light{};
  light.radius = 0.5f;
  const auto faces = light_buffer::light_faces(light, {glm::vec3(-4), glm::vec3(4)});
  const std::array<glm::dvec3, 3> corners{glm::dvec3(2, -1, 0), {2, 1, 0}, {3, 0, 0.01}};
  size_t shown = 0;
  for (const light_buffer::Face& face : faces.faces) {
    fill_stack();
    const auto footprint = light_buffer::area_footprint(face, faces.diameter, light.radius, corners);
    if (!footprint) continue;
    ++shown;
    EXPECT_FALSE(footprint->regular);
    for (size_t i = 0; i < 3; ++i) {
      EXPECT_EQ(footprint->edges[i], glm::dvec3(0)) << i;
      EXPECT_EQ(footprint->slack[i], std::numeric_limits<double>::infinity()) << i;
    }
    EXPECT_TRUE(light_buffer::meets(*footprint, footprint->box));
  }
  EXPECT_GT(shown, 0u);
}

INSTANTIATE_TEST_SUITE_P(
    Soups, AreaExactness,
    testing::Combine(testing::Values(Shape::even, Shape::tiny, Shape::huge, Shape::slivers, Shape::edge_on,
                                     Shape::touching, Shape::sheets, Shape::astride, Shape::around, Shape::grid),
                     testing::Values(Lamp::point, Lamp::spot)),
    [](const auto& soup) { return name(std::get<0>(soup.param)) + "_" + name(std::get<1>(soup.param)); });

}  // namespace
}  // namespace gnomon::test
